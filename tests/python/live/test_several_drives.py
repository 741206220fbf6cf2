"""Several drives in one process: each follows its own commands, and one that fails leaves the others their torque."""

import signal
from contextlib import ExitStack
from pathlib import Path

import pytest
import sextant
from drive_process import WIDE, DriveProcess
from sextant_py.paths import ROOT
from telemetry_record import TelemetryRecord

PATIENCE_S = 60.0
OFFSETS = {1: 0, 2: 32, 3: 64, 4: 96}
TORQUES_NM = {1: 15.0, 2: -12.0, 3: 20.0, 4: 8.0}
LIGHT = ("plant.integrator=fixed", "realtime.wake_every_periods=200", "dds.telemetry_rate_hz=100")
SETTINGS = (*WIDE, *LIGHT, "load.kind=imposed_speed", "load.speed_rad_s.value=40")
FOUR = ROOT / "configs" / "ecu_four.toml"


def follows(vehicle: sextant.Vcu, torque_nm: float) -> None:
    vehicle.run_until(lambda now: now.state == "TORQUE" and abs(now.torque_nm - torque_nm) < 5, PATIENCE_S)


def test_one_of_four_fails_and_the_others_keep_their_torque(live_bus: str, domain: int, tmp_path: Path) -> None:
    words = ("--fault-socket", tmp_path / "faults.sock", "--set-socket", tmp_path / "set.sock")
    with ExitStack() as stack:
        process = stack.enter_context(DriveProcess(live_bus, domain, tmp_path, SETTINGS, words, FOUR))
        vehicles = {
            number: stack.enter_context(sextant.Vcu(live_bus, identifier_offset=offset))
            for number, offset in OFFSETS.items()
        }
        records = {number: TelemetryRecord(domain, number) for number in OFFSETS}
        for number, vehicle in vehicles.items():
            vehicle.enable(PATIENCE_S)
            vehicle.demand(TORQUES_NM[number], enable=True)
            stack.enter_context(vehicle.repeating())
        for number in OFFSETS:
            follows(vehicles[number], TORQUES_NM[number])
        sextant.inject(tmp_path / "faults_2.sock", "open_phase", phase="b")
        records[2].wait(lambda own: own.states and own.states[-1].faults_latched, "the second drive's fault")
        with pytest.raises(sextant.UserError, match="on_fault never changes while the drives run"):
            sextant.set_parameters(tmp_path / "set_3.sock", {"on_fault": "all_shut_down"})
        sextant.set_parameters(tmp_path / "set_3.sock", {"protection.over_current_a": 180})
        assert sextant.get_parameters(tmp_path / "set_3.sock")["protection.over_current_a"] == 180
        assert sextant.get_parameters(tmp_path / "set_4.sock")["protection.over_current_a"] != 180
        for number in (1, 3, 4):
            vehicles[number].run(0.2)
            follows(vehicles[number], TORQUES_NM[number])
            assert not any(state.faults_latched for state in records[number].states)
        assert process.leave(signal.SIGTERM) == 0


def test_a_file_that_has_fewer_drives_meanwhile_is_no_basis(live_bus: str, domain: int, tmp_path: Path) -> None:
    tables = [
        f'[[drive]]\nbase = "{ROOT}/configs/ecu.toml"\ndrive_id = {number}\ncan.identifier_offset = {OFFSETS[number]}\n'
        for number in (1, 2)
    ]
    file = tmp_path / "two.toml"
    file.write_text("".join(tables), encoding="utf-8")
    with DriveProcess(live_bus, domain, tmp_path, SETTINGS, ("--set-socket", tmp_path / "set"), file) as process:
        TelemetryRecord(domain, 2).wait_until_heard()
        file.write_text(tables[0], encoding="utf-8")
        with pytest.raises(
            sextant.UserError, match=r"another one than at the start \(drives from 2 to 1\): restore it"
        ):
            sextant.set_parameters(tmp_path / "set_2", {"protection.over_current_a": 180})
        assert process.leave(signal.SIGTERM) == 0


def test_a_fault_of_one_shuts_all_down_and_ends_the_process(live_bus: str, domain: int, tmp_path: Path) -> None:
    words = ("--fault-socket", tmp_path / "faults.sock")
    settings = (*SETTINGS, "on_fault=all_shut_down")
    with ExitStack() as stack:
        process = stack.enter_context(DriveProcess(live_bus, domain, tmp_path, settings, words, FOUR))
        vehicles = [stack.enter_context(sextant.Vcu(live_bus, identifier_offset=OFFSETS[k])) for k in (1, 4)]
        for vehicle in vehicles:
            vehicle.enable(PATIENCE_S)
            vehicle.demand(15.0, enable=True)
            stack.enter_context(vehicle.repeating())
        for vehicle in vehicles:
            follows(vehicle, 15.0)
        sextant.inject(tmp_path / "faults_4.sock", "open_phase", phase="b")
        assert process.ended(PATIENCE_S) == 1
        assert "drive 4 went to FAULT (" in process.errors()
        assert "every drive has shut down (on_fault)" in process.errors()
        assert vehicles[0].state == "SHUTDOWN"
