"""The topics of a drive as groups of a recording: members, units and texts are those of the telemetry contract."""

import enum
import re
from typing import Any

import numpy as np

from .. import dds
from ..errors import UserError
from ..telemetry_contract import Signal, enumerations, enumerators, signals
from .model import MAIN, Column, Group

STATE = "drive_state"
WAVEFORM = "waveform"
TOPICS = {
    MAIN: dds.TELEMETRY,
    STATE: dds.STATE,
    "statistics": dds.STATISTICS,
    WAVEFORM: dds.WAVEFORM,
}
TEXTS = {
    MAIN: "DriveTelemetry, a row a sample",
    STATE: "DriveState, a row a change",
    "statistics": "RealTimeStatistics, a row a sample",
    WAVEFORM: "DriveWaveform, a row a control period; what holds for a batch is repeated",
}
OFFSETS = "offset_ns"  # of the rows of a batch, from its t_ns
_KINDS = {
    **{"unsigned long": "<u4", "unsigned long long": "<u8", "long": "<i4", "long long": "<i8"},
    **{"float": "<f4", "double": "<f8", "octet": "|u1", "boolean": "|u1"},
}
_TEXT, _SEQUENCE = re.compile(r"string<(\d+)>"), re.compile(r"sequence<(.+), *\d+>")


def struct_of(group: str) -> str:
    return TOPICS[group].partition("/")[2]


def kind_of(type_name: str) -> str:
    """The type of numpy for a type of the contract; of a sequence that of its elements."""
    if sequence := _SEQUENCE.fullmatch(type_name):
        return kind_of(sequence[1])
    if text := _TEXT.fullmatch(type_name):
        return f"|S{text[1]}"
    if type_name in enumerations():
        return "|u1"
    if type_name not in _KINDS:
        raise UserError(f'the telemetry contract has the type "{type_name}", which no recording can hold yet.')
    return _KINDS[type_name]


def column_of(signal: Signal) -> Column:
    text = signal.text
    if signal.type in enumerations():
        names = enumerators(signal.type)
        text += " (" + ", ".join(f"{value} {name}" for value, name in enumerate(names)) + ")"
    return Column(signal.name, kind_of(signal.type), signal.unit, text)


def group_of(name: str) -> Group:
    members = [signal for signal in signals(struct_of(name)) if signal.name != OFFSETS]
    return Group(name, tuple(column_of(signal) for signal in members), TEXTS[name])


def plain(value: Any) -> Any:
    """As numpy stores it."""
    if isinstance(value, enum.Enum):
        return value.value
    return value.encode() if isinstance(value, str) else value


def rows_of(group: Group, samples: list[Any]) -> np.ndarray:
    """Samples of a topic as rows."""
    if group.name == WAVEFORM:
        return np.concatenate([batch_rows(group, sample) for sample in samples])
    names = group.dtype.names
    return np.array([tuple(plain(getattr(sample, name)) for name in names) for sample in samples], group.dtype)


def batch_rows(group: Group, batch: Any) -> np.ndarray:
    """A row for each control period of a batch."""
    offsets = np.array(getattr(batch, OFFSETS), np.int64)
    rows = np.empty(len(offsets), group.dtype)
    for name in group.dtype.names:
        value = getattr(batch, name)
        rows[name] = value if np.isscalar(value) else np.fromiter(value, group.dtype[name], len(offsets))
    rows["t_ns"] = batch.t_ns + offsets
    return rows


def batches_of(rows: np.ndarray) -> list[np.ndarray]:
    """The rows of the batches, by their sequence number."""
    return np.split(rows, np.flatnonzero(np.diff(rows["sequence"].astype(np.int64))) + 1)


def sample_of(name: str, row: np.void | np.ndarray, kind: type) -> Any:
    """A sample from a row, a batch from its rows. A member that the recording lacks is zero."""
    from .. import telemetry_types

    first = row[0] if name == WAVEFORM else row
    values: dict[str, Any] = {}
    for signal in signals(struct_of(name)):
        if signal.name == OFFSETS:
            values[OFFSETS] = (row["t_ns"] - first["t_ns"]).tolist()
        elif signal.name in row.dtype.names:
            many = _SEQUENCE.fullmatch(signal.type)
            one = first[signal.name].item()
            values[signal.name] = elements(signal, row[signal.name]) if many else member(signal, one)
    return telemetry_types.sample(kind, **values)


def elements(signal: Signal, values: np.ndarray) -> list:
    kind = np.dtype(kind_of(signal.type))
    return [whole(signal.name, kind, value) for value in values.tolist()] if kind.kind in "iu" else values.tolist()


def whole(name: str, kind: np.dtype, value: Any) -> int:
    """A number for a member of whole ones. A file of other origin may have it in floating point, or out of range."""
    limits = np.iinfo(kind)
    if not limits.min <= value <= limits.max or abs(value - round(value)) > 1e-9 * max(1, abs(value)):
        expected = f"a whole number from {limits.min} to {limits.max}"
        raise UserError(f"the recording has {name} {value}, where the telemetry contract has {expected}.")
    return round(value)


def member(signal: Signal, value: Any) -> Any:
    from .. import telemetry_types

    if signal.type in enumerations():
        try:
            return telemetry_types.enum(signal.type)(value)
        except ValueError:
            raise UserError(
                f"the recording has {signal.name} {value}, which {signal.type} of the telemetry contract does not name."
            ) from None
    if signal.type == "boolean":
        return bool(value)
    kind = np.dtype(kind_of(signal.type))
    if kind.kind == "S":
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    if isinstance(value, bytes):
        raise UserError(f"the recording has a text as {signal.name}, where the telemetry contract has a number.")
    return whole(signal.name, kind, value) if kind.kind in "iu" else value
