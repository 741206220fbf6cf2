"""The shell scripts: what they say of themselves, and that set-up is quick when there is nothing to do."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from programs import modules_called
from sextant_py import commands
from sextant_py.paths import ROOT

SCRIPTS = ROOT / "scripts"
WITHOUT_OPERANDS = [
    "setup",
    "demo",
    "bench",
    "nightly",
    "check_dashboard",
    "check_demo",
    "check_format",
    "check_instructions",
    "check_package",
    "check_rtsan",
    "work_precision",
]
SHELL_SCRIPTS = [*WITHOUT_OPERANDS, "with_vcan", "test", "check_control_thread_audit"]
COMMANDS = sorted(link.name for link in SCRIPTS.iterdir() if link.is_symlink())  # programs of Python alone
PYTHON_PROGRAMS = [*COMMANDS, "compare_live", "check_recording", "fault_campaign"]


def run(*command: str | Path, **options: object) -> subprocess.CompletedProcess:
    return subprocess.run(command, capture_output=True, text=True, timeout=960, **options)


@pytest.mark.parametrize("name", SHELL_SCRIPTS + PYTHON_PROGRAMS)
def test_help_from_any_directory(name: str, tmp_path: Path) -> None:
    found = run(SCRIPTS / name, "--help", cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert name in found.stdout.splitlines()[0]
    assert found.stderr == ""


def test_every_command_is_a_link_to_the_one_that_runs_its_module() -> None:
    assert set(commands.COMMANDS) <= set(COMMANDS)
    for name in COMMANDS:
        assert (SCRIPTS / name).readlink() == Path("command"), name
        assert len(modules_called(name)) == 1, name
    found = run(SCRIPTS / "command", "plot")
    assert (found.returncode, found.stderr) == (1, "command: call a command by its name, as in scripts/plot --help.\n")


def test_a_link_elsewhere_runs_the_command_of_its_name(tmp_path: Path) -> None:
    for name in ("plot", "plots"):
        (tmp_path / name).symlink_to(SCRIPTS / "plot")
    found = run(tmp_path / "plot", "--help", cwd=tmp_path)
    assert (found.returncode, found.stdout) == (0, run(SCRIPTS / "plot", "--help").stdout)
    found = run(tmp_path / "plots", "--help", cwd=tmp_path)
    assert (found.returncode, found.stderr) == (1, "plots: call a command by its name, as in scripts/plot --help.\n")


@pytest.mark.parametrize("name", PYTHON_PROGRAMS)
def test_help_has_examples(name: str) -> None:
    said = run(SCRIPTS / name, "--help").stdout
    examples = re.split(r"^examples?:$", said, flags=re.MULTILINE)[1]
    assert name in examples


@pytest.mark.parametrize("name", WITHOUT_OPERANDS)
def test_unknown_arguments_are_refused(name: str) -> None:
    found = run(SCRIPTS / name, "--frobnicate")
    assert found.returncode == (1 if name == "check_coverage" else 2)
    assert found.stderr == f'{name}: unknown argument "--frobnicate"; see {name} --help.\n'


def builders() -> list[str]:
    """The commands that build something, or have it installed, and take no other command's words."""
    scripts = {path.name: path.read_text() for path in SCRIPTS.iterdir() if path.is_file() and not path.is_symlink()}
    builds = [name for name, text in scripts.items() if re.search(r"build_preset|cmake --|scripts/setup\"", text)]
    linked = {
        name for line in re.findall(r"^  (.*)\) mil_module", scripts["command"], re.M) for name in line.split(" | ")
    }
    return sorted((linked | set(builds)) - {"lib.sh", "setup", "test", "nightly"})


BEHIND_RIGHT_ONES = [("check_cortex_m", "--update"), ("fault_campaign", "--quick"), ("identify", "--live")]


@pytest.mark.parametrize(("name", "before"), [*((name, None) for name in builders()), *BEHIND_RIGHT_ONES])
def test_a_wrong_argument_is_refused_before_anything_is_built(name: str, before: str | None, tmp_path: Path) -> None:
    for tool in ("cmake", "ninja", "apt-get", "dpkg-query", "sudo", "npm", "ctest"):
        (tmp_path / tool).write_text(f"#!/bin/sh\necho {tool} >>{tmp_path}/called\nexit 97\n")
        (tmp_path / tool).chmod(0o755)
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    found = run(SCRIPTS / name, *([before] if before else []), "--frobnicate", env=environment, cwd=ROOT)
    assert not (tmp_path / "called").exists(), found.stderr
    assert found.returncode == (1 if name in ("check_coverage", "check_sanitizers") else 2), found.stderr
    assert re.search(r"--frobnicate|arguments are required|^check_sanitizers: say ", found.stderr)


def test_setup_is_quiet_when_nothing_is_missing(tmp_path: Path) -> None:
    found = run(SCRIPTS / "setup", cwd=tmp_path, stdin=subprocess.DEVNULL)
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")


def test_setup_leaves_an_environment_alone_that_it_reaches_by_a_link(elsewhere: Path) -> None:
    (elsewhere / "scripts" / "packages.txt").write_text("bash\n")
    (elsewhere / ".cache").mkdir(exist_ok=True)
    (elsewhere / ".cache" / "guest-kernel").symlink_to(
        ROOT / ".cache" / "guest-kernel"
    )  # where it is needed, it is there
    other = elsewhere / "other checkout"
    (other / "bin").mkdir(parents=True)
    (elsewhere / ".venv").symlink_to(other)
    found = run(elsewhere / "scripts" / "setup")
    assert found.returncode == 1
    assert "which has no Python; run scripts/setup there." in found.stderr
    (other / "bin" / "python").symlink_to("/usr/bin/python3")
    (other / ".fingerprint").write_text("of the other checkout\n")
    (elsewhere / "scripts" / "requirements.txt").write_text("# pinned\npip==0.0.1\nno-such-package-here==1.2  # why\n")
    found = run(elsewhere / "scripts" / "setup")
    assert (found.returncode, found.stderr) == (0, "")
    assert found.stdout == (
        f"setup: .venv links to {other}, which is left as it is and lacks 2 of the Python packages of "
        "scripts/requirements.txt: pip==0.0.1 no-such-package-here==1.2\n"
    )
    (elsewhere / "scripts" / "requirements.txt").write_text("# nothing\n")
    found = run(elsewhere / "scripts" / "setup")
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")
    assert (other / "bin" / "python").exists()
    assert (other / ".fingerprint").read_text() == "of the other checkout\n"


def test_monitor_from_a_directory_that_cyclone_would_split(tmp_path: Path, domain: int) -> None:
    """Spaces and commas in the path of the tree: DDS starts, with the tree's own configuration."""
    tree = tmp_path / "space, comma & 100 %"
    shutil.copytree(SCRIPTS, tree / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "configs", tree / "configs")
    (tree / ".venv").symlink_to(ROOT / ".venv")
    environment = {key: value for key, value in os.environ.items() if key != "CYCLONEDDS_URI"}
    found = run(tree / "scripts" / "monitor", "--once", "--duration", "0.5", "--domain", str(domain), env=environment)
    assert found.returncode == 1
    assert found.stderr.startswith(f"monitor: no other DDS participant was discovered (domain {domain}, configs/"), (
        found.stderr
    )


def test_format_gate_fails_where_git_lists_nothing(elsewhere: Path) -> None:
    environment = {**os.environ, "CLANG_FORMAT": str(ROOT / ".venv" / "bin" / "clang-format")}
    found = run(elsewhere / "scripts" / "check_format", env=environment)
    assert found.returncode == 1
    assert "check_format: no C++ file was found" in found.stderr


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A copy of the scripts whose machine lacks one package, and has vcan."""
    shutil.copytree(SCRIPTS, tmp_path / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "scripts" / "packages.txt").write_text("bash\nno-such-package-here # comment\n")
    boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    findings = tmp_path / ".cache" / "with_vcan" / boot
    findings.mkdir(parents=True)
    (findings / "vcan_works").write_text("yes\n")
    return tmp_path


def test_setup_without_apt_says_so(elsewhere: Path) -> None:
    programs = elsewhere / "bin"
    programs.mkdir()
    for name in ("bash", "dirname", "basename", "mkdir", "flock", "sed", "id", "cat"):
        (programs / name).symlink_to(shutil.which(name))
    found = run(elsewhere / "scripts" / "setup", env={"PATH": str(programs)})
    assert found.returncode == 1
    assert found.stderr.startswith("setup: this is not a Debian-like system (no apt-get)")
    assert found.stderr.count("\n") == 1


def test_setup_without_rights_names_what_is_missing(elsewhere: Path) -> None:
    programs = elsewhere / "bin"
    programs.mkdir()
    (programs / "id").write_text("#!/bin/sh\necho 1000\n")
    (programs / "sudo").write_text("#!/bin/sh\nexit 1\n")
    for program in programs.iterdir():
        program.chmod(0o755)
    path = f"{programs}:{os.environ['PATH']}"
    found = run(elsewhere / "scripts" / "setup", env={**os.environ, "PATH": path}, stdin=subprocess.DEVNULL)
    assert found.returncode == 1
    expected = "setup: these packages are missing and installing them needs root or sudo: no-such-package-here.\n"
    assert found.stderr == expected


def packages_of(name: str) -> set[str]:
    lines = (SCRIPTS / name).read_text(encoding="utf-8").splitlines()
    return {word for line in lines for word in line.split("#")[0].split()}


def test_what_only_gates_need_is_installed_for_them_alone(elsewhere: Path) -> None:
    assert packages_of("packages_gates.txt").isdisjoint(packages_of("packages.txt"))
    for name in ("demo", "test"):
        assert "--gates" not in (SCRIPTS / name).read_text(encoding="utf-8")
    assert {"clang-22", "valgrind", "gcc-arm-none-eabi", "qemu-system-arm"} <= packages_of("packages_gates.txt")
    (elsewhere / "scripts" / "packages.txt").write_text("bash\n")
    (elsewhere / "scripts" / "packages_gates.txt").write_text("no-such-package-here\n")
    (elsewhere / ".venv").symlink_to(ROOT / ".venv")
    found = run(elsewhere / "scripts" / "setup")
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")
    programs = elsewhere / "bin"
    programs.mkdir()
    (programs / "apt-get").write_text("#!/bin/sh\nexit 0\n")
    (programs / "sudo").write_text('#!/bin/sh\nexec "$@"\n')
    for program in programs.iterdir():
        program.chmod(0o755)
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    gates = [
        ("setup", "--gates"),
        ("check_rtsan",),
        ("check_instructions",),
        ("check_cortex_m",),
        ("bench", "--only", "control"),
    ]
    for name, *arguments in gates:
        found = run(elsewhere / "scripts" / name, *arguments, env=environment)
        assert found.returncode == 1, name
        assert found.stderr == "setup: no package source of this system offers: no-such-package-here.\n", name


@pytest.mark.parametrize("name", PYTHON_PROGRAMS)
def test_programs_before_setup_name_it(name: str, elsewhere: Path) -> None:
    found = run(elsewhere / "scripts" / name)
    assert found.returncode == 1
    assert found.stderr == f"{name}: the Python packages are not installed yet; scripts/setup does it.\n"
