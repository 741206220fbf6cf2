"""`sextant.Vcu` with the CAN side of a drive, over UDP multicast."""

import threading
import time

import can
import pytest
import sextant
from fake_drive import FakeDrive
from sextant_py.commander import Commander
from sextant_py.contract import Contract

WAIT_S = 240.0  # nothing is judged by time


def enables(drive: FakeDrive) -> list[bool]:
    return [str(command["Enable"]) == "ENABLE" for _, command in drive.accepted]


def wait_for_disables(drive: FakeDrive, count: int) -> None:
    deadline = time.monotonic() + WAIT_S
    while any(enables(drive)[-count:]) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert enables(drive)[-count:] == [False] * count


def unit(address: str, **options: object) -> sextant.Vcu:
    return sextant.Vcu(address, identifier_offset=0, **options)


def test_enable_demand_and_disable(bus_address: str) -> None:
    with FakeDrive(bus_address) as drive:
        with unit(bus_address, keeps_sent=True) as vcu:
            vcu.enable(WAIT_S)
            assert vcu.state == "TORQUE"
            vcu.demand(-20.0, enable=True)
            vcu.run_until(lambda vcu: vcu.torque_nm == pytest.approx(-20.0), WAIT_S)
            assert vcu.latest["MCU_Temperatures"]["StatorTemperature"] == pytest.approx(71.5)
            assert vcu.frames == len(vcu.sent)
            assert [counter for *_, counter in vcu.sent] == [n % 15 for n in range(vcu.frames)]
        wait_for_disables(drive, 5)
        assert not enables(drive)[0]
        assert drive.refused == 0


def test_a_context_that_raises_disables(bus_address: str) -> None:
    with FakeDrive(bus_address) as drive:
        with pytest.raises(ZeroDivisionError), unit(bus_address) as vcu:
            vcu.enable(WAIT_S)
            raise ZeroDivisionError
        wait_for_disables(drive, 5)
        assert any(enables(drive))


def test_a_close_sends_nothing_more(bus_address: str) -> None:
    with FakeDrive(bus_address) as drive:
        vcu = unit(bus_address)
        vcu.enable(WAIT_S)
        vcu.close()
        assert vcu.unsent == 0
        assert enables(drive)[-1]


def test_a_fault_is_raised_and_reset_on_demand(bus_address: str) -> None:
    with FakeDrive(bus_address, fault_after=0) as drive, unit(bus_address) as vcu:
        with pytest.raises(sextant.UserError, match=r"^the drive went to FAULT \(no reason reported\) when it was en"):
            vcu.enable(WAIT_S)
        with pytest.raises(sextant.UserError, match=r"^the drive is in FAULT \(.*\); .* \(reset_faults=True\) asks"):
            vcu.make_ready(WAIT_S)
        drive.never_faults()
        vcu.enable(WAIT_S, reset_faults=True)
        assert vcu.state == "TORQUE"
        assert any(command["FaultReset"] for _, command in drive.accepted)
        assert not any(command["FaultReset"] for _, command in drive.accepted if str(command["Enable"]) == "ENABLE")


def test_faults_have_their_names(bus_address: str) -> None:
    with FakeDrive(bus_address) as drive, unit(bus_address) as vcu:
        drive.faults = ("OVER_CURRENT", "COMMAND_LOST")
        vcu.run_until(lambda vcu: vcu.first_fault is not None, WAIT_S)
        vcu.run_until(lambda vcu: bool(vcu.faults_active) and bool(vcu.faults_latched), WAIT_S)
        assert vcu.first_fault == "OVER_CURRENT"
        assert vcu.faults_active == {"OVER_CURRENT"}
        assert vcu.faults_latched == {"OVER_CURRENT", "COMMAND_LOST"}


def test_within_repeating_a_thread_sends(bus_address: str) -> None:
    with FakeDrive(bus_address) as drive, unit(bus_address) as vcu:
        with vcu.repeating():
            vcu.enable(WAIT_S)
            vcu.demand(30.0, enable=True)
            vcu.run_until(lambda vcu: vcu.torque_nm == pytest.approx(30.0), WAIT_S)
            before, deadline = vcu.frames, time.monotonic() + WAIT_S
            while vcu.frames < before + 20 and time.monotonic() < deadline:
                time.sleep(0.01)  # the caller's own work
            assert vcu.frames >= before + 20
            with pytest.raises(sextant.UserError, match="repeats its demand once"), vcu.repeating():
                pass
        after = vcu.frames
        time.sleep(0.1)
        assert vcu.frames == after
        assert drive.refused == 0


class SlowBus:
    """Takes its time for a frame, in which other threads run."""

    def __init__(self) -> None:
        self.counters: list[int] = []

    def send(self, frame: can.Message) -> None:
        time.sleep(0.001)
        self.counters.append(frame.data[1] & 0x0F)


def test_frames_of_two_threads_are_in_sequence() -> None:
    """As those of `send` within `repeating`."""
    bus = SlowBus()
    commander = Commander(bus, Contract(identifier_offset=0), 0.01, 100.0)

    def send() -> None:
        for _ in range(20):
            commander.send(1.0, False)

    threads = [threading.Thread(target=send) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert bus.counters == [n % 15 for n in range(40)]


@pytest.mark.parametrize("kind", ["crc", "data_id", "reserved", "repeated", "jumped"])
def test_a_drive_refuses_wrong_frames(bus_address: str, kind: str) -> None:
    with FakeDrive(bus_address) as drive, unit(bus_address) as vcu:
        vcu.enable(WAIT_S)
        vcu.spoil(kind, 2)
        before = vcu.frames
        vcu.run_until(lambda vcu: drive.refused >= 2 or vcu.frames > before + 100, WAIT_S)
        vcu.run(0.1)
        assert drive.refused == 2
        assert vcu.state == "TORQUE"


def test_what_cannot_be_meant_is_refused(bus_address: str) -> None:
    with unit(bus_address) as vcu:
        assert (vcu.state, vcu.torque_nm, vcu.first_fault, vcu.is_ready) == (None, None, None, False)
        for torque_nm in (250.01, -1e9, float("nan"), float("inf")):
            with pytest.raises(sextant.UserError, match=r"leaves the contract's -250 to 250 N·m; spoil\("):
                vcu.demand(torque_nm, enable=True)
            with pytest.raises(sextant.UserError, match=r"leaves the contract's -250 to 250 N·m; spoil\("):
                vcu.send(torque_nm, enable=True)
        for duration_s in (-0.1, float("nan"), float("inf")):
            for call in (vcu.run, vcu.make_ready, vcu.enable, lambda t: vcu.run_until(lambda _: False, t)):
                with pytest.raises(sextant.UserError, match=r"^a time of \S+ s is neither 0 s nor a finite longer one"):
                    call(duration_s)
        assert vcu.frames == 0
        with pytest.raises(sextant.UserError, match=r'^"nonsense" is no kind of wrong frame; known are crc, '):
            vcu.spoil("nonsense")
        for frames in (-1, 0):
            with pytest.raises(sextant.UserError, match=rf"^{frames} wrong frames cannot be sent: 1 or more can"):
                vcu.spoil("crc", frames)
        with pytest.raises(sextant.UserError, match=r"^no status frame from a drive .* within 0\.05 s"):
            vcu.enable(0.05)
    for options, reason in [
        ({"period_s": 0.0}, "the period of commands must be 0.001 to 1 s, not 0 s."),
        ({"torque_limit_nm": 251.0}, "the torque limit 251 N·m is not 0 to 250 N·m."),
        ({"torque_limit_nm": float("nan")}, "the torque limit nan N·m is not 0 to 250 N·m."),
        ({"log": "commands.log"}, "a vehicle control unit has a bus, a log or a drive in lockstep, one of them."),
    ]:
        with pytest.raises(sextant.UserError) as refused:
            unit(bus_address, **options)
        assert str(refused.value) == reason
