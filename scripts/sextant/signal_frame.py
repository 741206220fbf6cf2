"""A trace or a recording as a pandas DataFrame."""

import warnings
from pathlib import Path

import numpy as np
import pandas
from sextant_py.errors import UserError
from sextant_py.signal_file import SignalFile


def plain(values: np.ndarray) -> np.ndarray:
    """Texts as str, numbers as they are."""
    if values.dtype.kind != "S":
        return values
    return np.array([value.decode("utf-8", "replace") for value in values.tolist()], object)


def read(file: str | Path, group: str | None = None) -> pandas.DataFrame:
    """The signals of a trace or a recording, a column each, over time.

    group: of a recording, such as `waveform`; None: the telemetry, of a trace with `plant/…` and `control/…`.

    The index is the time in seconds, `t_s`, from the beginning of a trace's run or the first sample of a recording. A
    row ends at its time: its means, minima and maxima are of the time since the row before, all else is at its time.
    `attrs["units"]` and `attrs["descriptions"]` have unit and meaning of each column. docs/recordings.md lists the
    formats. Warns of a truncated file, of which the rows are returned that are left. Raises UserError, with a sentence,
    where the file cannot be read.
    """
    found = SignalFile(Path(file))
    if found.cut:
        warnings.warn(found.cut, stacklevel=2)
    if group is not None and group not in found.groups:
        raise UserError(f'{file} has no group "{group}"; it has {", ".join(found.groups)}.')
    signals = found.signals(found.of_main() if group is None else [group], with_texts=True)
    prefix = "" if group in (None, found.main) else f"{group}/"
    named = {name.removeprefix(prefix): name for name in signals.values}
    values = {name: plain(signals.values[full]) for name, full in named.items()}
    frame = pandas.DataFrame(values, index=pandas.Index(signals.time_s, name="t_s"))
    frame.attrs["units"] = {name: signals.units[full] for name, full in named.items()}
    frame.attrs["descriptions"] = {name: signals.texts[full] for name, full in named.items()}
    return frame
