"""Parameters that a running drive takes on its socket, under torque."""

import signal
import stat
from pathlib import Path

import pytest
import sextant
from drive_process import WIDE, DriveProcess
from telemetry_record import TelemetryRecord

PATIENCE_S = 60.0
# At a wake-up many control periods, for a slow guest.
LIGHT = ("plant.integrator=fixed", "realtime.wake_every_periods=200", "dds.telemetry_rate_hz=100")
SETTINGS = (*WIDE, *LIGHT, "control.controller=foc", "load.kind=imposed_speed", "load.speed_rad_s.value=40")
TRIP = "protection.over_current_a"


def test_a_drive_under_torque_takes_a_limit_and_trips_by_it(live_bus: str, domain: int, tmp_path: Path) -> None:
    socket = tmp_path / "set"
    words = ("--set-socket", socket)
    with DriveProcess(live_bus, domain, tmp_path, SETTINGS, words) as drive, sextant.Vcu(live_bus) as vcu:
        telemetry = TelemetryRecord(domain)
        vcu.enable(PATIENCE_S)
        vcu.demand(140, enable=True)
        vcu.run_until(lambda now: abs(now.torque_nm - 140) < 10, PATIENCE_S)
        assert stat.S_IMODE(socket.stat().st_mode) == 0o600
        with pytest.raises(sextant.UserError, match=r"control\.flux_reference_wb changes only with the gates off"):
            sextant.set_parameters(socket, {"control.flux_reference_wb": 0.9})
        with pytest.raises(sextant.UserError, match=r"the change is refused: drive.period_us never changes"):
            sextant.set_parameters(socket, {"drive.period_us": 50})
        assert sextant.set_parameters(socket, {"control.foc.bandwidth_rad_s": 1000})
        vcu.run(0.2)
        assert vcu.state == "TORQUE", "what is refused, and another gain, leave the drive its torque"
        changed = sextant.set_parameters(socket, {TRIP: 32})
        assert any(line.startswith(f"{TRIP} from ") and line.endswith(" to 32") for line in changed)
        # Where a machine that stood still has taken the torque away just then, the current limit that follows counts.
        vcu.run_until(lambda now: now.state in ("FAULT", "DERATED"), PATIENCE_S)
        vcu.run(0.2)
        if vcu.state == "FAULT":
            assert vcu.first_fault == "OVER_CURRENT"
        assert sextant.get_parameters(socket)[TRIP] == 32
        telemetry.wait(lambda own: own.statistics and own.statistics[-1].parameter_sets == 2, "two sets of parameters")
        assert drive.leave(signal.SIGTERM) == 0
        assert "parameters 3 at " in drive.errors(), "the refused one has a number too"
    assert not socket.exists()
