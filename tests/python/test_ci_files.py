"""The files of examples/ci: their commands run here; of those that set a machine up the parts are looked for."""

import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest
import yaml
from programs import program
from sextant_py.paths import ROOT

CI = ROOT / "examples" / "ci"
BUILT = "build/release/apps/"
PARTS = re.compile(r"(scripts/setup|cmake --preset \w+|cmake --build --preset \w+ --target [\w -]+)")


def github_commands() -> list[str]:
    workflow = yaml.safe_load((CI / "github-actions.yml").read_text(encoding="utf-8"))
    steps = workflow["jobs"]["scenarios"]["steps"]
    return [line for step in steps for line in step.get("run", "").splitlines()]


def gitlab_commands() -> list[str]:
    return yaml.safe_load((CI / "gitlab-ci.yml").read_text(encoding="utf-8"))["scenarios"]["script"]


def container_commands() -> list[str]:
    lines = (CI / "Containerfile").read_text(encoding="utf-8").splitlines()
    return [part for line in lines if line.startswith("RUN ") for part in line.removeprefix("RUN ").split(" && ")]


def check_set_up(command: str) -> None:
    """Script, presets and targets exist."""
    assert PARTS.fullmatch(command), command
    words = shlex.split(command)
    if words == ["scripts/setup"]:
        assert os.access(ROOT / words[0], os.X_OK)
        return
    presets = (ROOT / "CMakePresets.json").read_text(encoding="utf-8")
    assert f'"name": "{words[words.index("--preset") + 1]}"' in presets
    if "--target" in words:
        programs = (ROOT / "apps" / "CMakeLists.txt").read_text(encoding="utf-8")
        for target in words[words.index("--target") + 1 :]:
            assert f"sextant_add_program({target}\n" in programs or f"sextant_add_program({target} " in programs


@pytest.mark.parametrize(
    ("commands", "reports"), [(github_commands(), 2), (gitlab_commands(), 1)], ids=["github", "gitlab"]
)
def test_the_commands_run_and_leave_their_reports(commands: list[str], reports: int, tmp_path: Path) -> None:
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    (tmp_path / BUILT).parent.mkdir(parents=True)
    (tmp_path / BUILT).symlink_to(program("sextant-mil").parent)
    ran = 0
    for command in commands:
        if not command.startswith(BUILT):
            check_set_up(command)
            continue
        environment = {**os.environ, "GITHUB_STEP_SUMMARY": str(tmp_path / "summary.md")}
        done = subprocess.run(
            ["bash", "-ec", command], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        ran += 1
    assert len(list((tmp_path / "out").glob("*.xml"))) == ran == reports


def test_the_image_has_the_programs_that_it_starts() -> None:
    commands = container_commands()
    for command in commands:
        check_set_up(command)
    assert commands[0] == "scripts/setup"
    assert "sextant-mil" in commands[-1]
