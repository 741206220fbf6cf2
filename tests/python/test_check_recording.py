"""check_recording finds what is missing and not counted."""

from pathlib import Path

import numpy as np
import pytest
from made_recording import made, whole, write
from sextant_py import check_recording
from sextant_py.recording import topics
from sextant_py.recording.losses import LossCounter
from sextant_py.recording.mcap_source import McapSource
from sextant_py.recording.model import MAIN

SEED = 31


def recorded(telemetry_without: slice, periods_without: slice, missed: int, counted: bool, path: Path) -> McapSource:
    """A file that lacks some rows, whose drive says that it has missed so many control periods."""
    source = made(SEED, telemetry=800, periods=28_000)
    telemetry, waveform = whole(source, MAIN), whole(source, topics.WAVEFORM)
    telemetry["sequence"], telemetry["dropped"] = np.arange(len(telemetry)), 0
    source._blocks[MAIN] = np.delete(telemetry, telemetry_without)
    source._blocks[topics.WAVEFORM] = np.delete(waveform, periods_without)
    statistics = whole(source, "statistics")
    statistics["t_ns"] = np.linspace(waveform["t_ns"][0], waveform["t_ns"][-1], len(statistics)).astype(np.int64)
    statistics["sequence"] = np.arange(len(statistics))
    statistics["periods_missed"] = 0
    statistics["periods_missed"][-1] = missed
    source._blocks["statistics"] = statistics
    counter = LossCounter()
    for name in source.groups if counted else ():
        for block in source.blocks(name):
            counter.take(name, block)
    source.metadata["losses"] = counter.described()
    write(source, path)
    return McapSource(path)


@pytest.mark.parametrize(
    ("telemetry_without", "periods_without", "missed", "counted", "failures"),
    [
        (slice(0, 0), slice(0, 0), 0, True, []),
        (slice(100, 103), slice(0, 0), 0, True, []),
        (slice(0, 0), slice(500, 520), 20, True, []),
        (slice(0, 0), slice(800, 840), 0, True, []),  # a whole batch: its number is missing
        (slice(0, 0), slice(0, 0), 0, False, ["the file's losses are not those of its rows"]),
        (slice(0, 0), slice(500, 520), 19, True, ["20 control periods are missing, of which no more than 19 are"]),
    ],
)
def test_what_is_missing_has_to_be_counted(
    tmp_path: Path, telemetry_without: slice, periods_without: slice, missed: int, counted: bool, failures: list[str]
) -> None:
    source = recorded(telemetry_without, periods_without, missed, counted, tmp_path / "run.mcap")
    figures, said = check_recording.check_losses(source)
    assert len(said) == len(failures), said
    for found, expected in zip(said, failures, strict=True):
        assert found.startswith(expected)
    removed = len(range(800)[telemetry_without])
    assert (figures["telemetry_rows"], figures["telemetry_lost"]) == (800 - removed, removed)
    gone = len(range(28_000)[periods_without])
    assert (figures["control_periods"], figures["periods_missing"]) == (28_000 - gone, gone)


def test_a_recording_without_control_periods_fails(tmp_path: Path) -> None:
    source = made(SEED)
    del source.groups[topics.WAVEFORM]
    write(source, tmp_path / "run.mcap")
    assert check_recording.check_losses(McapSource(tmp_path / "run.mcap")) == ({}, ["the recording has no waveform"])


def test_files_that_hold_other_rows_fail(tmp_path: Path) -> None:
    source, shorter, other = made(SEED), made(SEED, telemetry=699), made(SEED + 1)
    for name, written in (("run", source), ("shorter", shorter), ("other", other)):
        write(written, tmp_path / f"{name}.mcap")
        write(written, tmp_path / f"{name}.mf4")
    found = McapSource(tmp_path / "run.mcap")
    failures: dict[str, list[str]] = {}
    for name in ("run", "shorter", "other"):
        failures[name] = check_recording.check_mcap(tmp_path / f"{name}.mcap", found)
        failures[name] += check_recording.check_mdf(tmp_path / f"{name}.mf4", found)
    assert failures == {
        "run": [],
        "shorter": ["mcap counts other messages", "asammdf counts other rows"],
        "other": ["asammdf reads another torque_mean_nm", "asammdf reads another torque_nm"],
    }
