"""A live drive is recorded whole: a few seconds of what scripts/check_recording does for minutes."""

import json
import os
import subprocess
from pathlib import Path

from kernel import native_kernel_only
from made_recording import reread
from programs import program
from sextant_py.paths import ROOT

MINUTES = 0.06


def test_a_live_drive_is_recorded_whole(live_bus: str, domain: int, tmp_path: Path) -> None:
    native_kernel_only()
    folder = program("sextant-ecu").parent
    words = ["--minutes", MINUTES, "--bin", folder, "--can", live_bus, "--domain", domain, "--out", tmp_path]
    command = [str(word) for word in (ROOT / "scripts" / "check_recording", *words)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=dict(os.environ))
    assert found.returncode == 0, found.stdout + found.stderr
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    print(report)
    assert report["failures"] == []
    assert report["telemetry_rows"] > 500
    assert report["control_periods"] > 20_000
    assert report["can_frames"] > 100
    # Reception and telemetry are on one clock: the command that a row names was received just before it.
    found = reread(tmp_path / "run.mcap")
    commands = {int(t_ns) for block in found.blocks("can/VCU_TorqueCommand") for t_ns in block["t_ns"]}
    named = {int(t_ns) for block in found.blocks("telemetry") for t_ns in block["command_received_ns"][-500:]} - {0}
    assert named
    nearest = [min(abs(t_ns - other) for other in commands) for t_ns in named]
    assert sorted(nearest)[len(nearest) // 2] < 50_000_000
