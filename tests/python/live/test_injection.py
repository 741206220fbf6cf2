"""Faults that a running plant is given: the drive trips by each, and goes on once it is over."""

import signal
import stat
import subprocess
import time
from pathlib import Path

import pytest
import sextant
from drive_process import WIDE
from programs import ProgramProcess, overrides, program
from sextant_py import inject
from sextant_py.paths import ROOT

TORQUE_NM = 20.0
PATIENCE_S = 60.0
# At a wake-up many control periods, for a slow guest.
LIGHT = ("plant.integrator=fixed", "realtime.wake_every_periods=200", "dds.telemetry_rate_hz=100")
SETTINGS = (*WIDE, *LIGHT, "load.kind=imposed_speed", "load.speed_rad_s.value=40")


class FaultyPlant(ProgramProcess):
    """sextant-ecu or sextant-plant with a socket for faults."""

    def __init__(self, name: str, config: str, folder: Path, words: list[str]) -> None:
        self.socket = folder / "faults"
        self.said = folder / f"{name}.txt"
        command = [program(name), ROOT / "configs" / config, "--fault-socket", self.socket, *words]
        super().__init__(command, self.said, stderr=subprocess.STDOUT)

    def awaits_faults(self) -> None:
        for _ in range(int(PATIENCE_S / 0.1)):
            if self.socket.exists():
                return
            time.sleep(0.1)


def follows(vcu: sextant.Vcu) -> None:
    vcu.enable(PATIENCE_S, reset_faults=True)
    vcu.demand(TORQUE_NM, enable=True)
    vcu.run_until(lambda now: abs(now.torque_nm - TORQUE_NM) < 5, PATIENCE_S)


def test_a_running_drive_trips_by_each_injected_fault_and_returns(live_bus: str, domain: int, tmp_path: Path) -> None:
    words = ["--can", live_bus, *overrides((*SETTINGS, f"dds.domain={domain}"))]
    with FaultyPlant("sextant-ecu", "ecu_foc.toml", tmp_path, words) as drive, sextant.Vcu(live_bus) as vcu:
        # Either makes the torque wrong too, which is seen first where the machine stood still for the other check: that
        # each has its own name is claimed in virtual time.
        faults = {"OPEN_PHASE": ("open_phase", {"phase": "b"}), "SPEED_SENSOR": ("speed_jump", {"jump_rad_s": 100})}
        for name, (kind, values) in faults.items():
            follows(vcu)
            sextant.inject(drive.socket, kind, **values)
            vcu.run_until(lambda now: now.state == "FAULT", PATIENCE_S)
            vcu.run(0.2)
            assert vcu.first_fault in (name, "TORQUE_PLAUSIBILITY")
            sextant.inject(drive.socket, "none")
        follows(vcu)
        assert vcu.faults_latched == set()
        assert stat.S_IMODE(drive.socket.stat().st_mode) == 0o600
        with pytest.raises(sextant.UserError, match="kind") as refused:
            sextant.inject(drive.socket, "open_fase")
        assert "open_phase" in str(refused.value)
        with pytest.raises(sextant.UserError, match="unknown key"):
            sextant.inject(drive.socket, "none", seed=3)
        with pytest.raises(sextant.UserError, match=r'"contactor_welded", got "cables_swapped"'):
            inject.main([str(drive.socket), "cables_swapped"])
        vcu.run(0.1)
        assert vcu.state == "TORQUE", "what is refused changes nothing"
        drive.send_signal(signal.SIGTERM)
        assert drive.wait(PATIENCE_S) == 0
    said = drive.said.read_text(encoding="utf-8")
    assert said.count("plant fault injected at") == 4
    assert 'kind="open_phase" phase="b"' in said
    assert not drive.socket.exists()
    with pytest.raises(sextant.UserError, match="no program takes faults"):
        sextant.inject(drive.socket, "none")


def test_a_plant_of_its_own_takes_faults(tmp_path: Path) -> None:
    words = overrides((f"hil.link=faults_{tmp_path.stat().st_ino}", "period_us=1000"))
    with FaultyPlant("sextant-plant", "plant.toml", tmp_path, words) as plant:
        plant.awaits_faults()
        assert inject.main([str(plant.socket), "link_sag", "sag_v=300", "ramp_ms=10"]) == 0
        second = subprocess.run([*map(str, plant.command)], capture_output=True, text=True, timeout=PATIENCE_S)
        assert second.returncode == 2
        assert plant.is_running()
    assert 'kind="link_sag" sag_v=300 ramp_ms=10' in plant.text()


def test_a_plant_with_swapped_motor_cables_keeps_them(tmp_path: Path) -> None:
    words = overrides((f"hil.link=swapped_{tmp_path.stat().st_ino}", "plant.faults.kind=cables_swapped"))
    with FaultyPlant("sextant-plant", "plant.toml", tmp_path, words) as plant:
        plant.awaits_faults()
        for kind in ("none", "speed_lost"):
            with pytest.raises(sextant.UserError, match="motor cables are swapped from power-up on"):
                sextant.inject(plant.socket, kind)
        assert plant.is_running()
    assert "plant fault injected" not in plant.text()


def test_a_file_in_the_place_of_the_socket_is_kept(tmp_path: Path) -> None:
    kept = tmp_path / "faults"
    kept.write_text("mine", encoding="utf-8")
    command = [program("sextant-plant"), ROOT / "configs" / "plant.toml", "--fault-socket", kept]
    found = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert (found.returncode, kept.read_text(encoding="utf-8")) == (2, "mine")
    assert "no socket" in found.stderr


def test_a_drive_without_a_plant_of_its_own_refuses_the_socket(tmp_path: Path) -> None:
    command = [program("sextant-ecu"), ROOT / "configs" / "ecu_hil.toml", "--fault-socket", tmp_path / "faults"]
    found = subprocess.run(
        [*map(str, command), *overrides(("realtime.required=false",))],
        capture_output=True, text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    assert found.returncode == 2
    assert "give the option to its sextant-plant" in found.stderr
