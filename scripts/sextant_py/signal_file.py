"""Reads a trace of sextant-mil or a recording: every signal over one time axis, with unit and description."""

import io
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from .errors import UserError
from .telemetry_contract import signals

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
TOPIC = "DriveTelemetry"  # whose members a recording without units has


@dataclass
class Signals:
    """Signals over one time axis."""

    time_s: np.ndarray
    values: dict[str, np.ndarray]
    units: dict[str, str] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)

    def get(self, *names: str) -> np.ndarray | None:
        """The first of the signals that there is."""
        return next((self.values[name] for name in names if name in self.values), None)

    def between(self, wanted: np.ndarray) -> "Signals":
        """The samples at which `wanted` is true."""
        values = {name: value[wanted] for name, value in self.values.items()}
        return Signals(self.time_s[wanted], values, self.units, self.texts)


def text_of(attribute: str | bytes) -> str:
    return attribute.decode() if isinstance(attribute, bytes) else str(attribute)


def read_hdf5(path: Path) -> Signals:
    """Every dataset of one dimension in the root, `plant/` and `control/`."""
    found = Signals(np.empty(0), {})
    try:
        with h5py.File(path, "r") as file:
            for prefix in ("", "plant/", "control/"):
                group = file.get(prefix or "/")
                members = group.items() if isinstance(group, h5py.Group) else ()
                for name, data in members:
                    if isinstance(data, h5py.Dataset) and data.ndim == 1:
                        found.values[f"{prefix}{name}"] = data[()]
                        found.units[f"{prefix}{name}"] = text_of(data.attrs.get("unit", ""))
                        found.texts[f"{prefix}{name}"] = text_of(data.attrs.get("description", ""))
    except FileNotFoundError:
        raise UserError(f"{path} does not exist.") from None
    except OSError as error:
        raise UserError(_refusal(path, error)) from None
    return found


def _refusal(path: Path, error: OSError) -> str:
    try:
        with path.open("rb") as file:
            is_hdf5 = file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except OSError as reason:
        return f"{path} cannot be read: {reason.strerror}."
    if is_hdf5:
        return f"{path} is damaged or still being written: {error}; use another copy, or wait for the end of the run."
    return f"{path} is not an HDF5 file."


def read_csv(path: Path) -> Signals:
    """A column a signal; units and descriptions are those of the telemetry contract."""
    import pandas

    try:
        whole, _, rest = path.read_bytes().rpartition(b"\n")
        table = pandas.read_csv(io.BytesIO(whole))
    except FileNotFoundError:
        raise UserError(f"{path} does not exist.") from None
    except OSError as error:
        raise UserError(f"{path} cannot be read: {error.strerror}.") from None
    except ValueError as error:  # of pandas as well
        raise UserError(f"{path} is not a table of comma-separated values: {error}.") from None
    if rest:
        warnings.warn(f"{path}: the last line is not complete and is left out.", stacklevel=2)
    known = {signal.name: signal for signal in signals(TOPIC)}
    numeric = [name for name in table.columns if pandas.api.types.is_numeric_dtype(table[name])]
    found = Signals(np.empty(0), {name: table[name].to_numpy() for name in numeric})
    found.units = {name: known[name].unit if name in known else "" for name in numeric}
    found.texts = {name: known[name].text if name in known else "" for name in numeric}
    return found


# By the ending of the file's name: what reads it. A reader leaves `time_s` empty.
READERS: dict[str, Callable[[Path], Signals]] = {".h5": read_hdf5, ".hdf5": read_hdf5, ".csv": read_csv}


def reader_of(path: Path) -> Callable[[Path], Signals]:
    if path.suffix.lower() not in READERS:
        raise UserError(f'{path} has the ending "{path.suffix}"; known are {", ".join(READERS)}.')
    return READERS[path.suffix.lower()]


def load(path: Path, begin_s: float | None = None, end_s: float | None = None) -> Signals:
    """Reads t_s or t_ns and every signal of its length; time of t_ns counts from the first sample."""
    found = reader_of(path)(path)
    values = found.values
    if "t_ns" in values and len(values["t_ns"]):
        found.time_s = (values["t_ns"].astype(np.int64) - int(values["t_ns"][0])) / 1e9
    elif "t_s" in values and len(values["t_s"]):
        found.time_s = values["t_s"].astype(float)
    else:
        raise UserError(f"{path} has neither samples of t_s nor of t_ns, so it is no trace and no recording.")
    time_s = found.time_s
    found.values = {name: value for name, value in values.items() if len(value) == len(time_s)}
    wanted = (time_s >= (-np.inf if begin_s is None else begin_s)) & (time_s <= (np.inf if end_s is None else end_s))
    if not wanted.any():
        raise UserError(f"{path} has no sample in that span; it runs from {time_s[0]:g} s to {time_s[-1]:g} s.")
    return found.between(wanted)
