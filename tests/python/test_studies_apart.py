"""Studies use the product, and the product no study: imports of scripts/sextant_py by its syntax trees."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "scripts" / "sextant_py"
STUDIES = (
    "check_paper", "compare_controllers", "compare_motulator", "controller_", "cortex_", "false_trips",
    "fault_campaign", "honest_drive", "identify_study", "inverter_study", "machine_library", "motulator_", "paper_",
    "random_machines", "torque_map", "work_precision", "bench",
)  # fmt: skip


def module_name(file: Path, root: Path) -> str:
    return ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def imports(root: Path) -> set[tuple[str, str]]:
    files = {module_name(file, root): file for file in root.rglob("*.py")}
    found = set()
    for name, file in files.items():
        package = file.relative_to(root).parent.parts
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = [*package[: len(package) - node.level + 1], *(node.module or "").split(".")]
                module = ".".join(part for part in base if part)
                targets = {".".join(filter(None, (module, alias.name))) for alias in node.names}
                found |= {(name, target if target in files else module) for target in targets}
    return {(user, used) for user, used in found if used in files and used != user}


def of_study(module: str) -> bool:
    return module.startswith(STUDIES)


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
    assert {(user, used) for user, used in imports(PACKAGE) if of_study(used) and not of_study(user)} == set()


def test_modules_import_in_no_circle():
    assert circle(imports(PACKAGE)) == []


def test_import_of_a_study_and_a_circle_are_seen(tmp_path):
    (tmp_path / "plot.py").write_text("def f():\n    from . import paper_lab\n")
    (tmp_path / "paper_lab.py").write_text("from .plot import f\n")
    assert imports(tmp_path) == {("plot", "paper_lab"), ("paper_lab", "plot")}
    assert circle(imports(tmp_path))
