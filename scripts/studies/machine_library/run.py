"""Runs the points of the study over the library of machines, several at a time."""

import subprocess
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from sextant_py.sweep_file import Settings
from sextant_py.sweep_point import clean_reason, read_summary
from sextant_py.sweep_reader import set_words

from .points import Machine, Point, cell_settings, command_of, settings

TIME_LIMIT_S = 120  # of one run [s]
SHORT: Settings = {"duration_s": 0.001, "metrics.window_from_s": 0}
Record = dict


class Lab:
    """sextant-mil, and a scenario of each machine in the directory."""

    def __init__(self, mil: Path, machines: Iterable[Machine], directory: Path) -> None:
        self.mil, self.directory = mil, directory
        self.machines = {machine.id: machine for machine in machines}
        for machine in self.machines.values():
            self.scenario(machine.id).write_text(machine.scenario(), encoding="utf-8")
        self.configurations: dict[tuple[str, int, str], dict | str] = {}
        self.version = self.commit = ""

    def scenario(self, machine: str) -> Path:
        return self.directory / f"{machine}.toml"

    def summary_of(self, machine: str, settings: Settings) -> dict | str:
        """The summary of a run, or what sextant-mil says where it made none."""
        with tempfile.TemporaryDirectory(prefix="sextant-library-") as out:
            command = [str(self.mil), str(self.scenario(machine)), *set_words(settings), "--no-trace", "--out", out]
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S)
            except subprocess.TimeoutExpired:
                return f"no result within {TIME_LIMIT_S} s"
            # The place of the scenario says nothing: it is of this run.
            said = clean_reason(done.stderr, self.mil.name).removeprefix(f"{self.scenario(machine)}: ")
            return read_summary(Path(out)) or said or f"exit status {done.returncode}"

    def configure(self, points: Iterable[Point], jobs: int) -> None:
        """The configuration in force for each machine, period and method, or the sentence that refuses it."""
        cells = {(p.cell.machine, p.cell.period_us, p.cell.method): p.cell for p in points}
        missing = {key: cell for key, cell in cells.items() if key not in self.configurations}
        with ThreadPoolExecutor(jobs) as pool:
            found = pool.map(lambda cell: self.summary_of(cell.machine, cell_settings(cell) | SHORT), missing.values())
            for key, summary in zip(missing, found, strict=True):
                if isinstance(summary, dict):
                    self.version, self.commit = summary["version"], summary["commit"]
                    self.configurations[key] = summary["configuration"]
                else:
                    self.configurations[key] = summary

    def configuration(self, point: Point) -> dict | str:
        return self.configurations[point.cell.machine, point.cell.period_us, point.cell.method]

    def record(self, point: Point, more: Settings) -> Record:
        """Of one run: its refusal is empty where it has figures."""
        configuration, machine = self.configuration(point), self.machines[point.cell.machine]
        if isinstance(configuration, str):
            return {"key": point.key, "refusal": configuration}
        own = settings(point, machine, configuration) | more
        summary = self.summary_of(point.cell.machine, own)
        if isinstance(summary, str):
            return {"key": point.key, "refusal": summary}
        names = ("torque_bias_nm", "torque_motoring_nm", "torque_regenerating_nm", "torque_silent_ms")
        faults = [[fault["fault"], fault["t_s"]] for fault in summary["faults"]]
        command = command_of(point, machine, configuration)
        metrics = {name: summary["metrics"][name] for name in names}
        found = {"key": point.key, "refusal": "", "faults": faults, "verdict": summary["verdict"]}
        return found | {"command_nm": command} | metrics

    def run(
        self, work: list[tuple[Point, Settings]], jobs: int, step: Callable[[], None] = lambda: None
    ) -> list[Record]:
        """The records, in the order of the work: each a point and what is set beside it."""
        pool = ThreadPoolExecutor(jobs)
        try:
            begun = {pool.submit(self.record, *one): number for number, one in enumerate(work)}
            found: list[Record] = [{}] * len(work)
            for one in as_completed(begun):
                found[begun[one]] = one.result()
                step()
            return found
        finally:
            pool.shutdown(cancel_futures=True)
