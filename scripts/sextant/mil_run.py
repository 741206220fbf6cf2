"""One run of a scenario by sextant-mil."""

import subprocess
import tempfile
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas
from sextant_py import mil_program
from sextant_py.errors import UserError
from sextant_py.sweep_point import clean_reason, has_summary, read_summary
from sextant_py.sweep_reader import set_words

from .signal_frame import read


class Run:
    """The results of a run. Without a directory of its own they last as long as this object."""

    def __init__(self, directory: Path, summary: dict, said: str, keep: tempfile.TemporaryDirectory | None) -> None:
        self.directory = directory
        self.summary = summary  # summary.json: configuration in force, limits, faults and more
        self.said = said  # what the program reported on standard error, for a run that did not pass
        self._keep = keep

    @property
    def verdict(self) -> str:
        """`pass`, `fail`, `tripped`, …: docs/ci.md lists them."""
        return self.summary["verdict"]

    @property
    def metrics(self) -> dict[str, float | None]:
        """Metrics by name; None where the run gave none."""
        return self.summary["metrics"]

    @cached_property
    def trace(self) -> pandas.DataFrame:
        """Every signal of the trace over time; `attrs["units"]` has the units."""
        file = self.directory / "trace.h5"
        if not file.is_file():
            raise UserError(f"{self.summary['scenario']} ran without a trace; run it with trace=True.")
        return read(file)

    def __repr__(self) -> str:
        return f"<sextant.Run {self.summary['scenario']}: {self.verdict}>"


def run(
    scenario: str | Path, overrides: dict[str, Any] | None = None, out: str | Path | None = None, trace: bool = True
) -> Run:
    """Runs a scenario file and waits for its end.

    overrides: configuration keys, dotted, to values; `sextant-mil SCENARIO --print-config` lists them.
    out: the directory for trace.h5 and summary.json; None: a temporary one.
    trace: whether the run writes a trace.

    A run that does not pass is a result with another verdict. Raises UserError, with what sextant-mil reports, where it
    refuses scenario or override, or leaves no summary.
    """
    program = mil_program.find(None)
    keep = tempfile.TemporaryDirectory(prefix="sextant-run-") if out is None else None
    directory = Path(keep.name if keep else out)
    words = [str(program), str(scenario), "--out", str(directory), *set_words(overrides or {})]
    done = subprocess.run(
        words + ([] if trace else ["--no-trace"]),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        check=False,
    )
    reason = clean_reason(done.stderr, program.name)
    summary = read_summary(directory) if has_summary(done.returncode) else None
    if summary is None:
        raise UserError(reason or f"{program} left no summary and exit status {done.returncode}.")
    return Run(directory, summary, reason if done.returncode else "", keep)
