"""scripts/setup where neither the kernel nor the installed User Mode Linux offers vcan, and what scripts/with_vcan then
takes. Programs of the machine are made ones: no archive is asked, no guest boots."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

VERSION = "7.2um1"
# A made archive: `download` leaves one .deb, which the made dpkg-deb unpacks as the files that a guest needs.
PROGRAMS = {
    "apt-get": """case " $* " in
*" indextargets "*) echo "$MIRROR" ;;
*" update "*) exit $UPDATE ;;
*" download "*) touch user-mode-linux.deb; echo "$*" >>"$CALLS.download" ;;
esac""",
    "apt-cache": f"""case " $* " in
*" show "*) echo "Version: {VERSION}" ;;
*" depends "*) printf 'user-mode-linux\\n  Depends: libc6\\n  Suggests: rootstrap\\n' ;;
esac""",
    "dpkg": "echo amd64",
    "dpkg-deb": """to=$3/usr
mkdir -p "$to/bin" "$to/lib/x86_64-linux-gnu/gconv"
touch "$to/bin/linux.uml" "$to/lib/x86_64-linux-gnu/"{libc.so.6,ld-linux-x86-64.so.2}
kernel=$to/lib/uml/modules/7.2.7/kernel
mkdir -p "$kernel"/{drivers/net/can/dev,net/can,net/sched}
touch "$kernel"/drivers/net/can/{dev/can-dev,vcan,vxcan}.ko "$kernel"/net/can/can{,-raw,-bcm,-gw}.ko
[ -n "$LACKING" ] || touch "$kernel/net/sched/sch_tbf.ko\"""",
    "patchelf": 'echo "$*" >>"$CALLS.patchelf"',
}
WITH_VCAN = """#!/bin/bash
echo "$*" >>"$CALLS"
[ "$1" != --native ] || exit 125
[ ! -e "$(dirname "$0")/../.cache/guest-uml/linux.uml" ] || exit $FETCHED
echo "with_vcan: that is why" >&2
exit $INSTALLED
"""
FETCHING = (
    "setup: fetching user-mode-linux of Debian unstable (50 MB) into .cache/guest-uml: neither this kernel nor the"
    " installed User Mode Linux offers vcan here\n"
)
INSTEAD = "; vcan comes from a QEMU guest instead, where tests take several times longer\n"


class Tree:
    """The scripts beside a made archive, a made scripts/with_vcan, and a kernel for QEMU that is there already."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.scripts, self.uml = root / "scripts", root / ".cache" / "guest-uml"
        shutil.copytree(ROOT / "scripts", self.scripts, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("packages.txt", "packages_uml.txt", "packages_qemu.txt"):
            (self.scripts / name).write_text("bash\n")
        (root / ".venv").symlink_to(ROOT / ".venv")
        self.write("bin", {name: f"#!/bin/bash\n{text}\n" for name, text in PROGRAMS.items()})
        self.write("scripts", {"with_vcan": WITH_VCAN})
        self.write(".cache/guest-kernel", {"version": "there already\n"})

    def write(self, folder: str, files: dict[str, str]) -> None:
        (self.root / folder).mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            path = self.root / folder / name
            path.write_text(text)
            path.chmod(0o755)

    def setup(self, **found: str) -> str:
        """What it prints. `found`: exit statuses of both User Mode Linux and of `update`, address, lack of a file."""
        environment = {"CALLS": str(self.root / "calls"), "MIRROR": "http://archive.invalid/debian"}
        environment |= {"UPDATE": "0", "INSTALLED": "125", "FETCHED": "0", "LACKING": "", **found}
        path = f"{self.root / 'bin'}:{os.environ['PATH']}"
        ended = subprocess.run(
            [self.scripts / "setup"],
            env={**os.environ, **environment, "PATH": path},
            capture_output=True,
            text=True,
            timeout=960,
        )
        assert (ended.returncode, ended.stderr) == (0, "")
        return ended.stdout

    def calls(self, suffix: str = "") -> str:
        return (self.root / f"calls{suffix}").read_text()

    def finding(self, name: str) -> str | None:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        path = self.root / ".cache" / "with_vcan" / boot / name
        return path.read_text().strip() if path.exists() else None


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path / "a tree")


def test_an_installed_one_that_runs_is_enough(tree: Tree) -> None:
    assert tree.setup(INSTALLED="0") == ""
    assert tree.calls() == "--native true\n--uml -t 60 true\n"
    assert not tree.uml.exists()
    assert tree.setup(INSTALLED="125") == "", "what was found holds until the machine's next start"


def test_where_the_installed_one_does_not_run_another_is_fetched(tree: Tree) -> None:
    assert tree.setup() == FETCHING
    assert tree.calls() == "--native true\n--uml -t 60 true\n--uml -t 60 true\n"
    assert tree.calls(".download").endswith(" download user-mode-linux libc6\n")
    place = tree.uml
    assert tree.calls(".patchelf").startswith(f"--set-interpreter {place}/lib/ld-linux-x86-64.so.2 ")
    assert (place / "version").read_text() == f"{VERSION}\n{place}\n"
    assert (place / "modules/drivers/net/can/vcan.ko").exists()
    assert (place / "lib/libc.so.6").exists()
    assert sorted(path.name for path in (tree.root / ".cache").iterdir() if "uml" in path.name) == ["guest-uml"]
    assert (tree.finding("uml_fails"), tree.finding("vcan_works")) == (None, "yes")
    assert tree.setup() == ""


@pytest.mark.parametrize(
    ("found", "reason"),
    [
        ({"MIRROR": ""}, "no package source of this system is a Debian archive"),
        ({"UPDATE": "100"}, "apt-get could not read the suite unstable of http://archive.invalid/debian ("),
        ({"LACKING": "yes"}, f"user-mode-linux {VERSION} of Debian unstable lacks a file that guests need ("),
        ({"FETCHED": "125"}, f"user-mode-linux {VERSION} of Debian unstable does not offer vcan here: "),
        ({"FETCHED": "124"}, f"a guest of user-mode-linux {VERSION} of Debian unstable did not end within 60 s"),
    ],
)
def test_where_none_can_be_had_qemu_is_the_guest(found: dict[str, str], reason: str, tree: Tree) -> None:
    said = tree.setup(**found)
    assert said.startswith(f"{FETCHING}setup: {reason}")
    assert said.endswith(INSTEAD)
    assert said.count("\n") == 2
    assert [path.name for path in (tree.root / ".cache").iterdir() if "uml" in path.name] == []
    assert tree.finding("uml_fails") == "User Mode Linux offers no vcan here"
    assert (tree.finding("fetched_uml_fails") or "").startswith(reason)
    assert tree.setup(**found) == "", "it is not tried again before the machine's next start"


def test_a_guest_that_hangs_is_waited_for_once(tree: Tree) -> None:
    for _ in range(2):
        tree.setup(INSTALLED="124", UPDATE="100")
    assert tree.calls() == "--native true\n--uml -t 60 true\n"
    assert tree.finding("uml_fails") == "a User Mode Linux guest did not end within 60 s"


# A linux.uml whose guest ends at once, with success.
LINUX_UML = """#!/bin/bash
for word in "$@"; do case $word in init=*) work=$(dirname "${word#init=}") ;; esac; done
cp "$work/init" "$(dirname "$0")/init"
echo 0 >"$work/status"
"""


@pytest.mark.parametrize("moved", [False, True])
def test_a_fetched_one_is_taken_before_the_installed_one(moved: bool, tree: Tree) -> None:
    """Unless the tree was moved: it names its libraries by full path."""
    place = "/where/it/was" if moved else tree.uml
    tree.write(".cache/guest-uml", {"linux.uml": LINUX_UML, "version": f"{VERSION}\n{place}\n"})
    tree.write("bin", {"linux.uml": LINUX_UML})
    shutil.copy(ROOT / "scripts" / "with_vcan", tree.scripts)
    path = f"{tree.root / 'bin'}:{os.environ['PATH']}"
    command = [tree.scripts / "with_vcan", "--uml", "true"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=960, env={**os.environ, "PATH": path})
    name = "User Mode Linux" if moved else f"User Mode Linux ({VERSION} of Debian unstable)"
    assert (ended.returncode, ended.stderr) == (0, f"with_vcan: vcan0 of a guest of {name}\n")
    init = ((tree.root / "bin" if moved else tree.uml) / "init").read_text()
    modules = "/usr/lib/uml/modules/$(uname -r)/kernel" if moved else f"{tree.uml}/modules".replace(" ", "\\ ")
    assert f"\nmodules={modules}\n" in init


def test_in_qemu_only_what_needs_the_kernels_can_runs() -> None:
    """The other live tests are named as skipped, with the test that runs them."""
    command = [ROOT / ".venv/bin/python", "-m", "pytest", "-p", "no:cacheprovider", "--setup-plan", "tests/python/live"]
    environment = {**os.environ, "WITH_VCAN": "qemu", "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=960, env=environment)
    planned = set(re.findall(r"::(\w+) \(fixtures used", ended.stdout))
    assert planned == {
        "test_bad_frames_change_only_a_counter",
        "test_an_interface_that_comes_back_heals",
        "test_an_interface_that_stays_away_trips_the_drive",
        "test_status_frames",
    }
    assert "it needs no CAN of the kernel; live.udp_multicast runs it" in ended.stdout
