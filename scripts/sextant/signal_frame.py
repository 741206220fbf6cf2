"""A trace or a recording as a pandas DataFrame."""

from pathlib import Path

import pandas
from sextant_py import signal_file


def read(file: str | Path) -> pandas.DataFrame:
    """The signals of a trace or a recording, a column each, over time.

    The index is the time in seconds, `t_s`; that of a recording counts from its first sample. `attrs["units"]` and
    `attrs["descriptions"]` have unit and meaning of each column. The endings of `sextant_py.signal_file.READERS` are
    known. Raises UserError, with a sentence, where the file cannot be read.
    """
    found = signal_file.load(Path(file))
    values = {name: value for name, value in found.values.items() if name != "t_s"}
    frame = pandas.DataFrame(values, index=pandas.Index(found.time_s, name="t_s"))
    frame.attrs["units"] = {name: found.units.get(name, "") for name in frame}
    frame.attrs["descriptions"] = {name: found.texts.get(name, "") for name in frame}
    return frame
