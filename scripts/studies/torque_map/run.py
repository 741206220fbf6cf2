"""Runs the points of the torque map, several at a time; what has run once is kept and not run again."""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from sextant_py.append_file import AppendFile
from sextant_py.errors import UserError
from sextant_py.short_run import run_of
from sextant_py.sweep_file import Settings
from sextant_py.sweep_point import WITH_FIGURES
from sextant_py.sweep_program import fingerprint
from sextant_py.sweep_reader import set_words

from studies.parallel import as_finished

from .drive import Drive
from .points import Point, settings

METRICS = (
    "torque_deviation_nm",
    "torque_silent_ms",
    "torque_motoring_nm",
    "torque_regenerating_nm",
    "torque_bias_nm",
    "torque_ripple_pp_nm",
    "peak_current_a",
)
TIME_LIMIT_S = 120  # of one run [s]
BATCH = 2000  # points that wait at a time
VERDICTS = WITH_FIGURES | {"tripped", "no_torque"}  # whose figures tell what the drive did


class Lab:
    """One drive: its scenario, and the records of its runs in a file of lines of JSON."""

    def __init__(self, mil: Path, drive: Drive, directory: Path) -> None:
        self.mil, self.drive = mil, drive
        self.scenario = directory / f"{drive.name}.toml"
        self.file = directory / f"{drive.name}.jsonl"
        text = self.scenario.read_text(encoding="utf-8") + fingerprint(mil)
        self._identity = hashlib.sha256(text.encode()).hexdigest()
        self.records: dict[str, dict] = {}

    def command(self, settings: Settings) -> list[str]:
        return [str(self.mil), str(self.scenario), *set_words(settings), "--no-trace"]

    def take_up(self, restart: bool) -> int:
        """Reads what this program found of this drive before; the number of its points."""
        if restart or not self.file.exists():
            return 0
        lines = self.file.read_text(encoding="utf-8").split("\n")[:-1]
        if not lines or json.loads(lines[0]) != {"identity": self._identity}:
            return 0
        self.records = {record["key"]: record for record in map(json.loads, lines[1:])}
        return len(self.records)

    def run_one(self, key: str, settings: Settings) -> dict:
        """The record of one run; its reason is empty where it has figures."""
        ended = run_of(self.mil, self.scenario, settings, TIME_LIMIT_S)
        summary = ended.summary
        if summary is None or summary["verdict"] not in VERDICTS:
            return {"key": key, "reason": ended.said}
        metrics = {name: summary["metrics"][name] for name in METRICS}
        faults = [[fault["fault"], fault["t_s"]] for fault in summary["faults"]]
        return {"key": key, "reason": "", "faults": faults, **metrics}

    def run(self, points: Iterable[Point], jobs: int, step: Callable[[], None]) -> None:
        """Adds the records of the points that have none yet."""
        missing = self.missing(points)
        log = AppendFile(self.file, keep=bool(self.records))
        try:
            if not self.records:
                log.append(json.dumps({"identity": self._identity}) + "\n")
            for record in self._finished(missing, jobs):
                log.append(json.dumps(record) + "\n")
                self.records[record["key"]] = record
                step()
        except OSError as error:
            if error.filename and Path(error.filename) != self.file:
                raise UserError(f"{error.filename} cannot be run: {error.strerror}.") from None
            raise UserError(f"{self.file} cannot be written: {error.strerror}.") from None
        finally:
            log.close()

    def _finished(self, points: list[Point], jobs: int) -> Iterator[dict]:
        for first in range(0, len(points), BATCH):
            for _, record in as_finished(self._run_point, points[first : first + BATCH], jobs):
                yield record

    def missing(self, points: Iterable[Point]) -> list[Point]:
        """Those without a record of their present settings."""
        return [p for p in points if self.records.get(p.key, {}).get("settings") != self._digest(p)]

    def _digest(self, point: Point) -> str:
        return hashlib.sha256(json.dumps(settings(self.drive, point)).encode()).hexdigest()[:16]

    def _run_point(self, point: Point) -> dict:
        return self.run_one(point.key, settings(self.drive, point)) | {"settings": self._digest(point)}
