"""The scenarios of the paper as experiments: sextant-mil run at a setting, once, with its trace."""

import json
import math
import os
import shlex
import subprocess
import tempfile
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import h5py
from sextant_py import printed_configuration
from sextant_py.errors import EndedError
from sextant_py.paths import ROOT
from sextant_py.plots.trace import Trace
from sextant_py.sweep_point import WITH_FIGURES

SCENARIOS = Path("configs/scenarios/paper")
SAMPLED = {"mode": "sampled", "plant.integrator": "fixed"}
# Rows of a trace, where the report looks closer than the scenario's own trace does. [us]
ROWS_US = {
    "3_1_constant_torque": 100,
    "3_2_reversal": 50,
    "3_3_smooth": 100,
    "3_4_high_torque": 50,
    "3_5_nycc_linear": 2000,
    "3_5_nycc_clip": 2000,
    "3_5_nycc_origin": 2000,
    "sector_start_0": 100,
    "table6": 1000,
}
Settings = dict[str, object]


@dataclass(frozen=True)
class Run:
    """A run that has ended."""

    command: str
    metrics: dict[str, float]
    directory: Path

    def __getitem__(self, metric: str) -> float:
        return self.metrics[metric]

    @cached_property
    def trace(self) -> Trace:
        with h5py.File(self.directory / "trace.h5") as file:
            values = {name: file[name][()] for name in ("torque_reference_nm", "power_w")}
            values |= {name: data[()] for name, data in file["plant"].items()}
            return Trace(file["t_ns"][()] / 1e9, values)


def value_text(value: object) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


class Lab:
    """Runs scenarios of configs/scenarios/paper, several at a time; what has run once is not run again."""

    def __init__(self, mil: Path, jobs: int) -> None:
        self.mil = mil
        self._work = tempfile.TemporaryDirectory(prefix="sextant_paper_")
        self.work = Path(self._work.name)
        self._runs: dict[tuple, Future[Run]] = {}
        self._pool = ThreadPoolExecutor(jobs)

    def __enter__(self) -> "Lab":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)
        self._work.cleanup()

    def run(self, scenario: str, settings: Settings | None = None, trace: bool = False) -> Run:
        return self._begin(scenario, settings or {}, trace).result()

    def run_all(self, points: Iterable[tuple[str, Settings]], trace: bool = False) -> list[Run]:
        """In the order of the points."""
        return [begun.result() for begun in [self._begin(*point, trace) for point in points]]

    def configuration(self, scenario: str) -> str:
        """The configuration in force, as `--print-config` has it."""
        return printed_configuration.text_of(self.mil, ROOT / SCENARIOS / f"{scenario}.toml")

    def _begin(self, scenario: str, settings: Settings, trace: bool) -> "Future[Run]":
        if trace and scenario in ROWS_US:
            settings = {"trace.interval_us": ROWS_US[scenario]} | settings
        point = (scenario, tuple(sorted((key, value_text(value)) for key, value in settings.items())))
        for known in ((point, True), (point, trace)):
            if known in self._runs:
                return self._runs[known]
        directory = self.work / f"{len(self._runs):04d}"
        begun = self._pool.submit(self._start, scenario, settings, trace, directory)
        self._runs[point, trace] = begun
        return begun

    def _start(self, scenario: str, settings: Settings, trace: bool, directory: Path) -> Run:
        file = SCENARIOS / f"{scenario}.toml"
        arguments = [str(file)]
        for name, value in settings.items():
            arguments += ["--set", f"{name}={value_text(value)}"]
        silent = [] if trace else ["--no-trace"]
        found = subprocess.run(
            [self.mil, *arguments, *silent, "--out", directory],
            cwd=ROOT,
            capture_output=True,
            text=True,
            env=os.environ | {"LC_ALL": "C.UTF-8"},
        )
        summary = directory / "summary.json"
        content = json.loads(summary.read_text(encoding="utf-8")) if summary.is_file() else {}
        # A tripped drive or a failed integration leaves a summary too.
        if content.get("verdict") not in WITH_FIGURES or found.stderr.strip():
            raise EndedError(f"sextant-mil {shlex.join(arguments)} failed: {found.stderr.strip()[-300:]}")
        metrics = {name: math.nan if entry is None else entry for name, entry in content["metrics"].items()}
        return Run("sextant-mil " + shlex.join(arguments), metrics, directory)
