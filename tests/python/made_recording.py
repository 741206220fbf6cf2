"""A recording of random values, held in memory, and what tests compare."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from sextant_py.recording import can_frames, formats, topics
from sextant_py.recording.copying import copy
from sextant_py.recording.model import MAIN, Column, Group, Source

EXTREMES = Group(
    "extremes",
    (
        Column("t_ns", "<i8", "ns", "time"),
        *(
            Column(f"whole_{kind.strip('<|')}", kind, "1", f"whole numbers {kind}")
            for kind in ("<u8", "<i8", "|i1", "<u2")
        ),
        Column("single", "<f4", "N·m", "single precision, with a comma, and a “quote”"),
        Column("double", "<f8", "µs", "double precision"),
        Column("words", "|S24", "1", "text"),
    ),
    "values at the ends of their types",
)
WORDS = ("", "a, b", 'said "no"', "Größe µ", "0", "nan")
PERIODS = 40


class MadeSource:
    """A recording in memory."""

    def __init__(self, blocks: dict[str, np.ndarray], groups: list[Group]) -> None:
        self.metadata = {"program": "test", "drive_id": 3, "begin_ns": 5_000_000_000, "note": "N·m"}
        self.groups = {group.name: group for group in groups}
        self.cut = None
        self.paths = [Path("made")]
        self._blocks = blocks

    def rows(self, name: str) -> int:
        return len(self._blocks[name])

    def blocks(self, name: str, rows: int = 300) -> Iterator[np.ndarray]:
        for begin in range(0, len(self._blocks[name]), rows):
            yield self._blocks[name][begin : begin + rows]


def random_rows(group: Group, count: int, step_ns: int, random: np.random.Generator) -> np.ndarray:
    """Random bits in every column, times in order."""
    rows = np.zeros(count, group.dtype)
    for column in group.columns:
        kind = np.dtype(column.kind)
        if column.is_text:
            rows[column.name] = [random.choice(WORDS).encode() for _ in range(count)]
        elif kind.kind == "f":
            values = np.frombuffer(random.bytes(count * kind.itemsize), kind).copy()
            values[np.isnan(values)] = -0.0
            values[:3] = (np.inf, -np.inf, np.finfo(kind).smallest_subnormal)[:count]
            rows[column.name] = values
        else:
            limits = np.iinfo(kind)
            rows[column.name] = random.integers(limits.min, limits.max, count, kind, endpoint=True)
            rows[column.name][:2] = (limits.min, limits.max)[:count]
    rows["t_ns"] = 5_000_000_000 + step_ns * np.arange(count)
    return rows


def waveform_rows(count: int, random: np.random.Generator) -> np.ndarray:
    """Batches of PERIODS control periods of 25 µs."""
    group = topics.group_of(topics.WAVEFORM)
    rows = random_rows(group, count, 25_000, random)
    rows["sequence"] = np.arange(count) // PERIODS
    rows["period_ns"], rows["dropped"], rows["drive_id"] = 25_000, 0, 3
    for name in group.dtype.names:
        if rows[name].dtype.kind == "f":
            rows[name] = random.standard_normal(count)
    return rows


def frame_rows(count: int, random: np.random.Generator) -> np.ndarray:
    rows = np.zeros(count, can_frames.FRAMES.dtype)
    rows["t_ns"] = 5_000_000_000 + 1_000_000 * np.arange(count)
    rows["id"], rows["length"] = random.integers(0, 0x7FF, count), 8
    rows["data"] = [random.bytes(8).hex().encode() for _ in range(count)]
    return rows


def made(seed: int, telemetry: int = 700, periods: int = 5000) -> MadeSource:
    """All kinds of groups; the seed is printed."""
    print(f"seed {seed}")
    random = np.random.default_rng(seed)
    names = (MAIN, "drive_state", "statistics")
    groups = [*(topics.group_of(name) for name in (*names, topics.WAVEFORM)), can_frames.FRAMES, EXTREMES]
    counts = dict(zip(names, (telemetry, 5, 7), strict=True))
    blocks = {name: random_rows(topics.group_of(name), count, 1_000_000, random) for name, count in counts.items()}
    blocks |= {topics.WAVEFORM: waveform_rows(periods, random), can_frames.CAN: frame_rows(90, random)}
    blocks |= {EXTREMES.name: random_rows(EXTREMES, 200, 3_000_000, random)}
    return MadeSource(blocks, groups)


def write(source: Source, path: Path) -> None:
    copy(source, path, None, lambda share: None)


def whole(source: Source, name: str) -> np.ndarray:
    return np.concatenate([np.empty(0, source.groups[name].dtype), *source.blocks(name)])


def assert_same_values(found: np.ndarray, expected: np.ndarray) -> None:
    """To the bit, whatever the order of the columns."""
    assert set(found.dtype.names) == set(expected.dtype.names)
    for name in expected.dtype.names:
        assert found[name].tobytes() == expected[name].tobytes(), name


def assert_same(found: Source, expected: Source) -> None:
    """Groups, units, texts and every value."""
    assert set(found.groups) == set(expected.groups)
    for name, group in expected.groups.items():
        by_name = {column.name: column for column in found.groups[name].columns}
        assert by_name == {column.name: column for column in group.columns}
        assert found.groups[name].time_of == group.time_of
        values, wanted = whole(found, name), whole(expected, name)
        assert len(values) == len(wanted) == found.rows(name)
        assert_same_values(values, wanted)


def reread(path: Path) -> Source:
    return formats.open_source(path)


def write_cut(path: Path) -> None:
    """A recording of three rows as CSV, whose last line is not complete."""
    group = topics.group_of(MAIN)
    rows = np.zeros(3, group.dtype)
    rows["t_ns"], rows["torque_mean_nm"] = [0, 1_000_000, 2_000_000], [1.5, 2.25, 3.14]
    sink = formats.open_sink(path, {})
    sink.add(group)
    sink.append(MAIN, rows)
    sink.close({})
    path.write_bytes(path.read_bytes()[:-5])
