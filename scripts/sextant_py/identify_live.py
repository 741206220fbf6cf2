"""Runs the courses of `identify` with sextant-ecu: on its bus and clock, or in virtual time.

The drive is the live one, with its protections, commanded over CAN. It records its control periods; their replay by the
same program gives each gate pattern again, and with it telemetry and the channels of the control method.
"""

import subprocess
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from .control_unit import Vcu
from .errors import EndedError, UserError
from .identify_command import BRAKE_S, READY_S, REST_S, Commanded, Course
from .identify_run import Plant, Steps, configuration_of, following_states, gaps_of, given_words, read_columns
from .lockstep_bus import LockstepBus
from .printed_configuration import ECU
from .sweep_file import Settings
from .sweep_point import clean_reason
from .sweep_reader import set_words
from .vcu import Progress

LATER = 1.02  # time of a course by that without a missed control period
LEAVE_S = 20.0  # for the shutdown
ROWS_HZ = 1000  # of a trace
TRIES = 3  # of a course of torque


@dataclass(frozen=True)
class LivePlant(Plant):
    """The drive of a file of sextant-ecu with the power stage that it names."""

    ecu: Path
    directory: Path
    is_virtual: bool

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        return self._recorded(course, LATER * duration_s + 0.3, (), settings)

    def follow(
        self, course: str, torque: Steps, duration_s: float, settings: Settings, columns: Sequence[str]
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """Anew where the drive missed control periods."""
        for _ in range(TRIES):
            trace = self._recorded(course, duration_s, torque, settings)
            time, (state, *found) = read_columns(trace, ("state", *columns))
            flux_s = time[np.argmax(np.isin(state, following_states()))]
            gaps = gaps_of(trace) - flux_s
            if not np.any((gaps >= 0) & (gaps <= duration_s)):
                return time - flux_s, found
        raise EndedError(
            f"the drive missed control periods in each of {TRIES} courses of {course}; docs/realtime.md says what to "
            "change, and a longer drive.period_us takes less time."
        )

    def _recorded(self, course: str, duration_s: float, torque: Steps, settings: Settings) -> Path:
        cycles = self.directory / f"{course}_cycles.h5"
        words = [*self.given, *set_words(settings), "--record-cycles", str(cycles)]
        flux_s = 1e-3 * self.configuration["drive.magnetise_timeout_ms"]
        asked = Course(course, duration_s, torque, self.slowest_shaft, flux_s)
        record = self._record_in_virtual_time if self.is_virtual else self._record_live
        record(asked, words)
        return replayed(self.ecu, cycles, self.directory / f"{course}.h5")

    def _record_live(self, course: Course, words: list[str]) -> None:
        # A drive that nobody ends ends itself.
        longest_s = READY_S + REST_S + course.flux_s + course.duration_s + BRAKE_S + LEAVE_S
        command = [self.ecu, self.file, *words, "--duration", f"{longest_s:g}"]
        progress = Progress(quiet=False)
        ecu = EcuProcess(list(map(str, command)), self.directory / f"{course.name}.log")
        try:
            with ecu:
                with Vcu(self.configuration["can.bus"], identifier_offset=self._offset) as vcu:
                    Commanded(vcu, course, progress, ecu.check).run()
                ecu.leave()
        except KeyboardInterrupt:
            progress.say(f"{course.name}: stopped, {ecu.end}")
            raise
        progress.say(f"{course.name}: over, {ecu.end}")

    def _record_in_virtual_time(self, course: Course, words: list[str]) -> None:
        drive = LockstepBus(self.file, words, self.ecu)
        with Vcu(lockstep=drive, identifier_offset=self._offset) as vcu:
            Commanded(vcu, course, Progress(quiet=True), lambda: None).run()

    @property
    def _offset(self) -> int:
        return self.configuration["can.identifier_offset"]


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
    return LivePlant(given, configuration_of(ecu, file, given), file, ecu, directory, is_virtual)
