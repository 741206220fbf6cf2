"""Studies use the product, and the product no study: imports of scripts by their syntax trees."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def module_name(file: Path, root: Path) -> str:
    return ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def imports(root: Path) -> set[tuple[str, str]]:
    files = {module_name(file, root): file for file in root.rglob("*.py")}
    found = set()
    for name, file in files.items():
        package = file.relative_to(root).parent.parts
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {(name, alias.name) for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                base = package[: len(package) - node.level + 1] if node.level else ()
                module = ".".join(part for part in (*base, *(node.module or "").split(".")) if part)
                targets = {f"{module}.{alias.name}" for alias in node.names}
                found |= {(name, target if target in files else module) for target in targets}
    return {(user, used) for user, used in found if used in files and used != user}


def of_study(module: str) -> bool:
    return module.split(".")[0] == "studies"


def circle(pairs: set[tuple[str, str]]) -> list[str]:
    users: dict[str, set[str]] = {}
    for user, used in pairs:
        users.setdefault(user, set()).add(used)
    try:
        TopologicalSorter(users).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_product_imports_no_study():
    assert {(user, used) for user, used in imports(SCRIPTS) if of_study(used) and not of_study(user)} == set()


def test_modules_import_in_no_circle():
    assert circle(imports(SCRIPTS)) == []


def test_import_of_a_study_and_a_circle_are_seen(tmp_path):
    for name in ("sextant_py", "studies"):
        (tmp_path / name).mkdir()
    (tmp_path / "sextant_py" / "plot.py").write_text("def f():\n    from studies import lab\n")
    (tmp_path / "studies" / "lab.py").write_text("from sextant_py.plot import f\n")
    assert imports(tmp_path) == {("sextant_py.plot", "studies.lab"), ("studies.lab", "sextant_py.plot")}
    assert circle(imports(tmp_path))
