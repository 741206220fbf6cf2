"""Every command of docs/tutorial.md, in its order, in the directory of a checkout that is built."""

import json
import re
import subprocess
from pathlib import Path

import pytest
from programs import program
from sextant_py.paths import ROOT

PAGE = ROOT / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
BUS = "udp_multicast:239.74.163.2:43113"
# By .ci/run: a test cannot build what it runs in.
RUN_ELSEWHERE = ("scripts/setup", "cmake --preset release && cmake --build --preset release")


def blocks() -> list[str]:
    """The commands; the first block installs and builds."""
    first, *others = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert tuple(first.strip().splitlines()) == RUN_ELSEWHERE
    assert len(others) == 6
    return others


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A directory that looks like the checkout after the build, with results of its own."""
    for name in ("configs", "docs", "scripts", ".venv"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "build" / "release").mkdir(parents=True)
    (tmp_path / "build" / "release" / "apps").symlink_to(program("sextant-mil").parent)
    return tmp_path


def with_own_network(commands: str, bus_address: str, domain: int) -> str:
    """Bus and DDS domain are the test's own; the tutorial has the defaults."""
    assert commands.count(BUS) == 1
    group, port = bus_address.split(":")[1:]
    commands = commands.replace(f'"{BUS}"', f'"{bus_address}"\n[dds]\ndomain = {domain}')
    assert commands.count("can_client.py ") == 1
    return commands.replace("can_client.py ", f"can_client.py --group {group} --port {port} ")


def test_every_command_runs(checkout: Path, bus_address: str, domain: int) -> None:
    commands = with_own_network("\n".join(blocks()), bus_address, domain)
    script = f"set -eu\ntrap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n{commands}"
    done = subprocess.run(["bash", "-c", script], cwd=checkout, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    out = checkout / "out" / "tutorial"
    summaries = {name: json.loads((out / name / "summary.json").read_text()) for name in ("foc", "dtc")}
    assert [summary["verdict"] for summary in summaries.values()] == ["pass", "pass"]
    assert summaries["foc"]["configuration"]["machine.r_s_ohm"] == 1.405
    assert summaries["dtc"]["metrics"]["torque_ripple_pp_nm"] > 3 * summaries["foc"]["metrics"]["torque_ripple_pp_nm"]
    assert {"trace.png", "trace.spectrum.png"} <= {file.name for file in (out / "foc").iterdir()}
    assert "plotly.js v" in (out / "both.html").read_text(encoding="utf-8")
    assert re.search(r"values are out of tolerance: .*torque_ripple_pp_nm", done.stdout)
    torque = re.search(r"^TORQUE: \+(\d+\.\d\d) N·m of \+5\.00 N·m$", done.stdout, re.MULTILINE)
    assert torque, done.stdout + done.stderr
    assert float(torque[1]) == pytest.approx(5.0, abs=1.0)


def test_a_client_without_a_drive_says_so(bus_address: str, checkout: Path) -> None:
    group, port = bus_address.split(":")[1:]
    client = (ROOT / "docs" / "examples" / "can_client.py").read_text(encoding="utf-8")
    assert client.count("duration_s=30.0") == 1
    short = checkout / "docs_client.py"
    quick = client.replace("duration_s=30.0", "duration_s=0.2").replace(
        "Path(__file__).resolve().parents[2]", f"Path({str(ROOT)!r})"
    )
    short.write_text(quick, encoding="utf-8")
    command = [ROOT / ".venv" / "bin" / "python", short, "--group", group, "--port", port]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert done.stderr == f"can_client: no drive answers on {group}:{port}; is sextant-ecu running?\n"
