"""Runs the cases of the bench of control methods, several at a time, and keeps their figures."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py import printed_configuration
from sextant_py.errors import UserError
from sextant_py.short_run import run_of

from studies.command import write_toml
from studies.parallel import in_order
from studies.torque_map.drive import Drive

from .cases import SWITCHING_HZ, Case

METRICS = (
    "torque_ripple_rms_nm",
    "torque_ripple_pp_nm",
    "torque_bias_nm",
    "torque_error_rms_nm",
    "torque_deviation_nm",
    "response_time_ms",
    "flux_min_wb",
    "flux_max_wb",
    "switching_frequency_hz",
    "peak_current_a",
    "current_thd_percent",
    "energy_copper_j",
    "energy_from_link_j",
    "energy_to_link_j",
    "torque_motoring_nm",
    "torque_regenerating_nm",
)
TIME_LIMIT_S = 1800  # of one run [s]


def methods(mil: Path, scenario: Path) -> list[str]:
    """The control methods that this sextant-mil knows, by the key's own description."""
    text = printed_configuration.text_of(mil, scenario)
    line = next(line for line in text.splitlines() if line.startswith("controller = "))
    names = re.search(r'((?:"[\w-]+" or )*"[\w-]+"); default', line)
    if not names:
        raise UserError(f"sextant-mil names no control methods: {line}")
    return re.findall(r'"([\w-]+)"', names[1])


@dataclass
class Record:
    """What became of one case."""

    section: str
    method: str
    what: list
    reason: str = ""  # why there are no figures
    metrics: dict = field(default_factory=dict)


@dataclass
class Results:
    version: str
    commit: str
    methods: list[str]
    periods_us: dict[str, float]  # with the switching frequency in common, by method
    records: list[Record]
    step_ns: dict[str, float] = field(default_factory=dict)  # CPU time of a step, by method
    step: dict = field(default_factory=dict)  # curves of a torque step, as controller_step has them

    def of(self, section: str, method: str) -> list[Record]:
        return [r for r in self.records if (r.section, r.method) == (section, method)]

    def metric(self, section: str, method: str, what: Iterable, name: str) -> float | None:
        for record in self.of(section, method):
            if record.what == list(what):
                return record.metrics.get(name)
        return None


class Bench:
    """The drive of configs/ecu.toml, on which only the case's settings change."""

    def __init__(self, mil: Path, drive: Drive, directory: Path, jobs: int) -> None:
        self.mil, self.drive, self.jobs = mil, drive, jobs
        own = {"name": "controllers", "duration_s": 1}  # and no torque: a cycle brings one
        self.scenario = write_toml(directory / "controllers.toml", own | drive.base)

    def run(self, cases: list[Case], step: Callable[[], None]) -> list[Record]:
        return in_order(self._run, cases, self.jobs, step)

    def _run(self, case: Case) -> Record:
        settings = dict(case.settings) | {"control.controller": case.method}
        record = Record(case.section, case.method, list(case.what))
        ended = run_of(self.mil, self.scenario, settings, TIME_LIMIT_S)
        summary = ended.summary
        if summary is None:
            record.reason = ended.said
            return record
        record.metrics = {name: summary["metrics"].get(name) for name in METRICS}
        if summary["faults"]:
            record.reason = f"{summary['faults'][0]['fault']} at {summary['faults'][0]['t_s']:.3g} s"
        return record


def common_period(tuning: list[Record]) -> float:
    """The control period with which the method switches nearest to the frequency in common. [us]"""

    def distance(record: Record) -> float:
        frequency = record.metrics.get("switching_frequency_hz")
        return abs(frequency - SWITCHING_HZ) if frequency and not record.reason else float("inf")

    return min(tuning, key=distance).what[0]
