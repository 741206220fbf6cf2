"""Runs the courses of the control method commissioning with sextant-ecu: on its bus and clock, or in virtual time.

The drive is the live one, with its protections, commanded as by a vehicle: the hand-shake, an enable with 0 N·m for as
long as the course lasts, a disable. It records its control periods; their replay by the same program gives each gate
pattern again, and with it the channels of the control method.
"""

import re
import subprocess
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from . import printed_configuration
from .control_unit import Vcu
from .errors import EndedError, UserError
from .identify_run import Plant, given_words, tripped
from .printed_configuration import ECU
from .reports import RUNNING_STATES
from .sweep_file import Settings
from .sweep_point import clean_reason
from .sweep_reader import flat, set_words
from .vcu import Progress

READY_S = 30.0  # for the hand-shake
LATER = 1.02  # time of a course by that without a missed control period
LEAVE_S = 20.0  # for the shutdown
ROWS_HZ = 1000  # of a trace


@dataclass(frozen=True)
class LivePlant(Plant):
    """The drive of a file of sextant-ecu with the power stage that it names."""

    ecu: Path
    file: Path
    directory: Path
    is_virtual: bool

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        cycles = self.directory / f"{course}_cycles.h5"
        command = [self.ecu, self.file, *self.given, *set_words(settings), "--record-cycles", cycles]
        record = record_in_virtual_time if self.is_virtual else self._record_live
        record(course, duration_s, list(map(str, command)))
        return replayed(self.ecu, cycles, self.directory / f"{course}.h5")

    def _record_live(self, course: str, duration_s: float, command: list[str]) -> None:
        length_s = LATER * duration_s + 0.3
        # A drive that nobody ends ends itself.
        command = [*command, "--duration", f"{length_s + READY_S + LEAVE_S:g}"]
        bus, offset = self.configuration["can.bus"], self.configuration["can.identifier_offset"]
        progress = Progress(quiet=False)
        ecu = EcuProcess(command, self.directory / f"{course}.log")
        try:
            with ecu:
                with Vcu(bus, identifier_offset=offset) as vcu:
                    vcu.make_ready(READY_S, progress=ecu.check)
                    vcu.enable()
                    follow(vcu, ecu, course, length_s, progress)
                ecu.leave()
        except KeyboardInterrupt:
            progress.say(f"{course}: stopped, {ecu.end}")
            raise
        progress.say(f"{course}: over, {ecu.end}")


class EcuProcess:
    """sextant-ecu beside this program; a context, at whose end it shuts down whatever happened."""

    def __init__(self, command: list[str], log: Path) -> None:
        self._log = log
        with log.open("w", encoding="utf-8") as output:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(subprocess.TimeoutExpired):
            self._end()
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()

    @property
    def end(self) -> str:
        """What its end says of the drive, for a person."""
        status = self._process.poll()
        if status == 0:
            return "the drive is off"
        how = "has not ended yet" if status is None else f"did not shut down but ended with status {status}"
        return f"{ECU} {how}: see that the power stage is off"

    def check(self) -> None:
        """A UserError where it has ended."""
        status = self._process.poll()
        if status is not None:
            raise EndedError(f"{ECU} ended with status {status}: {self._reason()}")

    def leave(self) -> None:
        """Torque to zero, gates off, files closed."""
        try:
            status = self._end()
        except subprocess.TimeoutExpired:
            raise EndedError(
                f"{ECU} did not shut down within {LEAVE_S:g} s; {self._log} has what it reports."
            ) from None
        if status != 0:
            raise EndedError(f"{ECU} ended with status {status}: {self._reason()}")

    def _end(self) -> int:
        if self._process.poll() is None:
            self._process.terminate()
        return self._process.wait(LEAVE_S)

    def _reason(self) -> str:
        """The newest line that the program says of itself, else the newest."""
        lines = [line for line in self._log.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
        own = [line for line in lines if line.startswith(f"{ECU}: ")]
        return clean_reason((own or lines or ["it says nothing"])[-1], ECU)


def follow(vcu: Vcu, ecu: EcuProcess, course: str, length_s: float, progress: Progress) -> None:
    """Keeps the drive enabled for so long. Where it leaves torque, or is not there, the course ends with a sentence;
    leaving this function in whatever way ends with a disable."""
    begin = time.monotonic()
    while (passed := time.monotonic() - begin) < length_s:
        vcu.step()
        ecu.check()
        if vcu.state == "FAULT":
            raise tripped(vcu.first_fault or "a fault", course, f" at {passed:.3f} s")
        if not vcu.is_there:
            raise EndedError(f"the drive's status frames timed out {passed:.2f} s into the course of {course}.")
        if vcu.state not in RUNNING_STATES:
            raise EndedError(f"the drive left the course of {course} after {passed:.2f} s; it reports {vcu.state}.")
        progress.show(f"{course} {100 * passed / length_s:3.0f} % of {length_s:.1f} s  drive: {standing(vcu)}")


def standing(vcu: Vcu) -> str:
    """What the drive reports, for a person."""
    electrical = vcu.latest.get("MCU_Electrical")
    if not electrical:
        return str(vcu.state)
    return f"{vcu.state}, {electrical['PhaseCurrentRms']:.1f} A RMS, link {electrical['DcVoltage']:.1f} V"


def record_in_virtual_time(course: str, duration_s: float, command: list[str]) -> None:
    profile = Path(command[-1]).with_name(f"{course}.csv")
    profile.write_text(f"time_s,torque_nm\n0,0\n{duration_s:.6f},0\n", encoding="utf-8")
    words = [*command, "--virtual-time", "--profile", str(profile)]
    done = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode == 0:
        return
    if fault := re.search(r"went to FAULT \((\w+)\)", done.stderr):
        raise tripped(fault[1], course)
    raise EndedError(f"{ECU} ended with status {done.returncode}: {clean_reason(done.stderr, ECU)}")


def replayed(ecu: Path, cycles: Path, trace: Path) -> Path:
    """The trace of the recorded control periods, once each gate pattern has come again."""
    rate = set_words({"dds.telemetry_rate_hz": ROWS_HZ})
    command = [str(ecu), "--replay", str(cycles), "--telemetry-out", str(trace), *rate]
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode:
        raise UserError(
            f"{cycles} does not replay as it was recorded, so that its course tells nothing: "
            f"{clean_reason(done.stderr or done.stdout, ECU)}"
        )
    return trace


def live_plant(
    file: Path, ecu: Path, directory: Path, settings: Settings, own: list[str], is_virtual: bool
) -> LivePlant:
    """The drive of a file of sextant-ecu, with these settings and what the user sets."""
    given = given_words(settings, own)
    tables = printed_configuration.tables_of(ecu, file, given, "the drive")
    return LivePlant(given, flat(tables), ecu, file, directory, is_virtual)
