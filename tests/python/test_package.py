"""The Python package: installed by pip, it brings the command `sextant` and the files that its programs need."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from sextant_py.commands import COMMANDS
from sextant_py.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def run(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess:
    """Runs a command that finds the package where pip put it, and nowhere else."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        command, capture_output=True, text=True, timeout=600, cwd=cwd, env=environment, stdin=subprocess.DEVNULL
    )


@pytest.fixture(scope="module")
def sextant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command, installed without network into an environment that finds the dependencies of this one."""
    pytest.importorskip("setuptools", minversion="70.1", reason="scripts/setup installs setuptools 70.1 or newer")
    folder = tmp_path_factory.mktemp("package")
    tree, environment = folder / "tree", folder / "environment"
    ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in ("scripts/sextant", "scripts/sextant_py", "configs"):
        shutil.copytree(ROOT / name, tree / name, ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", tree)
    made = run(sys.executable, "-m", "venv", "--without-pip", environment, cwd=folder)
    assert made.returncode == 0, made.stderr
    packages = environment / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
    found = [path for path in sys.path if path.endswith("site-packages")]
    (packages / "dependencies.pth").write_text("\n".join(found) + "\n", encoding="utf-8")
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet", "--disable-pip-version-check")
    python = environment / "bin" / "python"
    installed = run(python, "-m", "pip", "install", *options, "--ignore-installed", tree, cwd=folder)
    assert installed.returncode == 0, installed.stdout + installed.stderr
    return environment / "bin" / "sextant"


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_every_command_says_what_it_does(sextant: Path, tmp_path: Path, name: str) -> None:
    found = run(sextant, *([name] if name else []), "--help", cwd=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert found.stdout.startswith(f"usage: {name or 'sextant'} ")


def test_the_programs_find_their_files(sextant: Path, tmp_path: Path) -> None:
    prefix = sextant.parents[1] / "share" / "sextant"
    script = "from sextant_py import paths, dds, contract, bus; contract.Contract(); print(paths.ROOT);"
    script += "print(bus.default_address(), len(dds.contract_fields('DriveTelemetry')))"
    found = run(sextant.with_name("python"), "-c", script, cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith(f"{prefix}\nudp_multicast:")
    refused = run(sextant, "vcu", "--profile", "no.csv", cwd=tmp_path)
    assert (refused.returncode, refused.stderr) == (
        2,
        "vcu: the profile no.csv cannot be read: No such file or directory.\n",
    )


def test_the_report_finds_its_page(sextant: Path, tmp_path: Path) -> None:
    (tmp_path / "j.xml").write_text('<testsuite name="s"><testcase name="good"/></testsuite>')
    found = run(sextant, "report", "j.xml", cwd=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert (tmp_path / "report.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_the_dashboard_has_all_that_its_page_loads(sextant: Path, tmp_path: Path) -> None:
    script = "from sextant_py.dashboard.server import PAGE; print(PAGE)"
    found = run(sextant.with_name("python"), "-c", script, cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    page = Path(found.stdout.strip())
    assert page.is_relative_to(sextant.parents[1])
    tree = ROOT / "scripts" / "sextant_py" / "dashboard" / "page"
    files = {file.relative_to(tree) for file in tree.rglob("*") if file.is_file()}
    assert Path("vendor/uplot/uPlot.esm.js") in files
    assert {file.relative_to(page) for file in page.rglob("*") if file.is_file()} == files


def test_an_unknown_command_is_refused(sextant: Path, tmp_path: Path) -> None:
    found = run(sextant, "nonsense", cwd=tmp_path)
    assert found.returncode == 2
    assert found.stderr.startswith('sextant: unknown command "nonsense"; known are vcu, ')


def test_version_and_dependencies_are_those_of_the_project() -> None:
    version = re.search(r"project\(Sextant VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
    assert PROJECT["project"]["version"] == version[1]
    pinned = re.findall(
        r"^([\w.-]+)==", (ROOT / "scripts" / "requirements.txt").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert set(PROJECT["project"]["dependencies"]) <= set(pinned)


def test_the_module_sextant_is_installed(sextant: Path, tmp_path: Path) -> None:
    (tmp_path / "recording.csv").write_text("t_ns,torque_mean_nm\n0,1.5\n1000000,2.5\n")
    script = "import sextant; frame = sextant.read('recording.csv'); print(sextant.__file__);"
    script += "print(frame['torque_mean_nm'].mean())"
    found = run(sextant.with_name("python"), "-c", script, cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith(str(sextant.parents[1]))
    assert found.stdout.splitlines()[1] == "2.0"
