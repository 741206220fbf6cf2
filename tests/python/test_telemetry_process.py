"""DDS runs in a process of its own: whatever becomes of it, the drive runs on and telemetry comes back."""

import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from programs import ProgramProcess, overrides, program
from sextant_py import bus, dds, telemetry_types
from sextant_py.contract import Contract
from sextant_py.paths import LOOPBACK, ROOT
from wrong_declarations import every

ONE = ROOT / "configs" / "ecu.toml"
FOUR = ROOT / "configs" / "ecu_four.toml"
STEP = 10  # processes of wrong readers
AT_ONCE = 2
PATIENCE_S = 120.0  # the machine may stand still for seconds; only a defect takes so long
ENVIRONMENT = {**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8").strip()}


def wait_for(condition: Callable[[], Any], what: str) -> Any:
    deadline = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        assert time.monotonic() < deadline, f"waited {PATIENCE_S:g} s for {what}"
        time.sleep(0.05)
    return value


class LiveDrive:
    """sextant-ecu, what it says on the bus, and a reader of its telemetry that knows the contract."""

    def __init__(self, address: str, domain: int, folder: Path, stack: ExitStack, file: Path = ONE) -> None:
        self.domain = domain
        settings = (f"dds.domain={domain}", "plant.integrator=fixed", "dds.statistics_rate_hz=10")
        command = [program("sextant-ecu"), file, "--can", address, *overrides(settings)]
        self.process = stack.enter_context(ProgramProcess(command, folder / "drive", env=ENVIRONMENT))
        self._contract = Contract()
        self._bus = bus.open_bus(bus.parse(address))
        stack.callback(self._bus.shutdown)
        self.telemetry = dds.Telemetry(domain)
        self.wait_for_telemetry()

    def wait_for_telemetry(self) -> None:
        """Samples of all three topics that are newer than this call."""
        last = self._newest_ns()
        wait_for(lambda: self.telemetry.poll() and self._newest_ns() > last, "DriveTelemetry")
        wait_for(lambda: self.telemetry.poll() is not None and self._drive().state, "DriveState")
        wait_for(lambda: self.telemetry.poll() is not None and self._drive().statistics, "RealTimeStatistics")

    def _drive(self) -> dds.Drive | None:
        return self.telemetry.drives.get(1)

    def _newest_ns(self) -> int:
        return self._drive().telemetry.t_ns if self._drive() else 0

    def periods(self) -> int:
        """Control periods run, by a statistics sample newer than this call."""
        before = self._drive().statistics.sequence
        wait_for(
            lambda: self.telemetry.poll() is not None and self._drive().statistics.sequence > before,
            "RealTimeStatistics",
        )
        return self._drive().statistics.periods

    def check_on_the_bus(self, frames: int = 20) -> None:
        """The drive runs and sends: so many status frames that were not sent before this call."""
        while bus.receive(self._bus, 0) is not None:
            pass
        heard = []
        deadline = time.monotonic() + PATIENCE_S
        while len(heard) < frames:
            assert self.process.is_running(), self.process.text()
            assert time.monotonic() < deadline, f"{len(heard)} status frames in {PATIENCE_S:g} s"
            frame = bus.receive(self._bus, 1.0)
            decoded = self._contract.decode(frame) if frame is not None else None
            if decoded and decoded[0] == "MCU_TorqueStatus":
                heard.append(decoded[1])

    def newest(self) -> Any:
        self.telemetry.poll()
        return self._drive().telemetry

    def newest_statistics(self, after_ns: int) -> Any:
        """A RealTimeStatistics of later control periods."""
        wait_for(
            lambda: self.telemetry.poll() is not None and self._drive().statistics.t_ns > after_ns,
            "RealTimeStatistics",
        )
        return self._drive().statistics

    def publisher(self) -> int | None:
        """The process that publishes now, of which there is one."""
        found = subprocess.run(
            ["pgrep", "-P", str(self.process.pid), "-x", "sextant-telemet"], capture_output=True, text=True
        )
        (publisher,) = found.stdout.split() or (None,)
        return int(publisher) if publisher else None

    def leave(self) -> str:
        """Ends it as a user would; the report."""
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(PATIENCE_S) == 0, self.process.text()
        return self.process.text()


@pytest.fixture
def drive(bus_address: str, domain: int, tmp_path: Path) -> Iterator[LiveDrive]:
    with ExitStack() as stack:
        yield LiveDrive(bus_address, domain, tmp_path, stack)


def wrong_readers(domain: int, first: int, step: int, hold_s: float) -> subprocess.Popen:
    command = [sys.executable, "wrong_readers.py", *map(str, (domain, first, step, hold_s))]
    path = os.pathsep.join([str(ROOT / "scripts"), str(ROOT / "tests" / "python")])
    return subprocess.Popen(
        command,
        cwd=ROOT / "tests" / "python",
        env={**ENVIRONMENT, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def test_there_are_enough_wrong_declarations() -> None:
    declarations = every()
    assert len({(one.topic, one.what) for one in declarations}) == len(declarations)
    for topic in (dds.TELEMETRY, dds.STATE, dds.STATISTICS):
        assert sum(one.topic == topic for one in declarations) >= 200


def test_no_declaration_of_a_reader_ends_the_drive(drive: LiveDrive) -> None:
    count = len(every())
    natural = wrong_readers(drive.domain, 0, count, 1000.0)  # sector as uint8, and it stays
    try:
        assert int(natural.stdout.readline()) == 1
        drive.wait_for_telemetry()
        declared = 0
        for first in range(0, STEP, AT_ONCE):
            some = [wrong_readers(drive.domain, first + k, STEP, 2.0) for k in range(AT_ONCE)]
            for readers in some:
                declared += int(readers.communicate(timeout=5 * PATIENCE_S)[0])
            drive.check_on_the_bus()
        print(f"\n{declared} wrong declarations")
        assert declared > 1000
        # All of it was the one drive, and who reads rightly still does while a wrong reader is there.
        assert natural.poll() is None
        drive.wait_for_telemetry()
        before = drive.periods()
        assert drive.periods() > before
    finally:
        natural.kill()
        natural.communicate()
    assert "Error" not in drive.leave()


@pytest.mark.parametrize("topic", [dds.TELEMETRY, dds.STATE, dds.STATISTICS])
def test_a_reader_of_an_earlier_version_reads(drive: LiveDrive, topic: str) -> None:
    """It declares the struct without its last member."""
    name = topic.partition("/")[2]
    kind = telemetry_types.struct(name, without=(list(telemetry_types.fields(name))[-1],))
    node = DomainParticipant(drive.domain)
    qos = dds.streaming_qos(1) if topic == dds.TELEMETRY else dds.latched_qos()
    reader = DataReader(node, Topic(node, topic, kind), qos)
    sample = wait_for(lambda: reader.take(N=1), name)[0]
    assert sample.drive_id == 1
    assert sample.t_ns > 0


def test_telemetry_comes_back_when_its_process_was_killed(drive: LiveDrive) -> None:
    before = drive.periods()
    first = wait_for(drive.publisher, "sextant-telemetry")
    os.kill(first, signal.SIGKILL)
    drive.check_on_the_bus()
    assert wait_for(lambda: (now := drive.publisher()) != first and now, "another sextant-telemetry")
    drive.wait_for_telemetry()
    assert drive.periods() > before, "it is the same drive"
    report = drive.leave()
    assert re.search(r"sextant-telemetry ended by signal 9 .*the drive runs on", report), report
    assert "sextant-telemetry was restarted 1 times" in report


STOPPED_PERIODS = 40_000  # a second; a process counts as stopped after two


def test_a_process_that_is_stopped_is_replaced_and_what_it_missed_is_counted(drive: LiveDrive) -> None:
    first = wait_for(drive.publisher, "sextant-telemetry")
    before = drive.newest().dropped
    os.kill(first, signal.SIGSTOP)
    begin_s = time.monotonic()
    assert wait_for(lambda: (now := drive.publisher()) != first and now, "another sextant-telemetry")
    print(f"replaced after {time.monotonic() - begin_s:.1f} s")
    drive.check_on_the_bus()
    drive.wait_for_telemetry()
    newest = drive.newest()
    assert newest.dropped - before > STOPPED_PERIODS
    assert drive.newest_statistics(newest.t_ns).telemetry_dropped >= newest.dropped
    report = drive.leave()
    assert re.search(r"sextant-telemetry has sent nothing for 2000 ms and is killed", report), report
    assert re.search(r"sextant-telemetry ended by signal 9 .*the drive runs on", report), report
    assert "sextant-telemetry was restarted 1 times" in report
    lost = int(re.search(r"(\d+) samples not published: sextant-telemetry did not receive them", report)[1])
    assert lost >= STOPPED_PERIODS / 40


def test_a_drive_whose_process_is_stopped_leaves(drive: LiveDrive) -> None:
    first = wait_for(drive.publisher, "sextant-telemetry")
    os.kill(first, signal.SIGSTOP)
    report = drive.leave()
    assert "did not end and was killed" in report or "is killed" in report, report
    assert drive.publisher() is None


def test_one_process_publishes_several_drives_and_is_replaced_for_all(
    bus_address: str, domain: int, tmp_path: Path
) -> None:
    with ExitStack() as stack:
        drives = LiveDrive(bus_address, domain, tmp_path, stack, FOUR)

        def newest() -> dict[int, int]:
            drives.telemetry.poll()
            return {
                number: drive.telemetry.t_ns for number, drive in drives.telemetry.drives.items() if drive.telemetry
            }

        def all_are_newer(than: dict[int, int]) -> bool:
            now = newest()
            return all(now.get(number, 0) > than.get(number, 0) for number in (1, 2, 3, 4))

        wait_for(lambda: all_are_newer({}), "DriveTelemetry of four drives")
        first = drives.publisher()
        os.kill(first, signal.SIGKILL)
        assert wait_for(lambda: (now := drives.publisher()) != first and now, "another sextant-telemetry")
        before = newest()
        wait_for(lambda: all_are_newer(before), "DriveTelemetry of four drives again")
        report = drives.leave()
    assert report.count("sextant-telemetry was restarted 1 times") == 1, report
    assert len(re.findall(r"^telemetry [1-9]\d* published", report, re.MULTILINE)) == 4, report


def test_the_process_leaves_when_its_drive_is_gone(drive: LiveDrive) -> None:
    publisher = wait_for(drive.publisher, "sextant-telemetry")
    watched = os.pidfd_open(publisher)
    try:
        drive.process.send_signal(signal.SIGKILL)
        drive.process.wait(PATIENCE_S)
        assert select.select([watched], [], [], PATIENCE_S)[0], "it is still there"
    finally:
        os.close(watched)


@pytest.mark.parametrize(
    ("uri", "expected"),
    [
        ("<CycloneDDS><Domain>", "<Domain> is not closed"),
        ("<CycloneDDS></Domain>", "mismatched tag"),
        ("file:///no/such/file.xml", "/no/such/file.xml"),
    ],
)
def test_a_configuration_that_cannot_be_used_is_refused(bus_address: str, domain: int, uri: str, expected: str) -> None:
    settings = (*overrides((f"dds.domain={domain}",)), "--duration", "1")
    done = subprocess.run(
        [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--can", bus_address, *settings],
        env={**os.environ, "CYCLONEDDS_URI": uri},
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 2
    assert re.fullmatch(r"sextant-ecu: DDS cannot start on domain \d+: .*\n", done.stderr), done.stderr
    assert expected in done.stderr
    assert "CYCLONEDDS_URI" in done.stderr


def test_dds_is_in_its_process_alone() -> None:
    def libraries(name: str) -> str:
        return subprocess.run(["ldd", program(name)], capture_output=True, text=True, check=True).stdout

    assert "libddsc" in libraries("sextant-telemetry")
    assert "libddsc" not in libraries("sextant-ecu")


def test_started_by_hand_it_says_who_starts_it() -> None:
    done = subprocess.run([program("sextant-telemetry")], capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 2
    sentence = "there is no drive to publish for: start sextant-ecu, which starts this program"
    assert done.stderr == f"sextant-telemetry: {sentence}\n"
