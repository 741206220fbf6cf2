"""Names of values in MDF4: what asammdf shows of states and causes of derating, and that the numbers stay."""

from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF
from made_recording import assert_same, made, reread, write
from sextant_py.recording.formats import open_sink
from sextant_py.recording.topics import group_of
from sextant_py.recording.value_texts import value_texts
from sextant_py.telemetry_contract import enumerators

STATES = ["INIT", "STANDBY", "READY", "MAGNETISING", "TORQUE", "DERATED", "FAULT", "SHUTDOWN"]
CAUSES = ["NONE", "CURRENT_LIMIT", "VOLTAGE_LIMIT", "TEMPERATURE", "DC_LINK_LOW", "GATES_OFF", "COMMAND_TIMEOUT"]
CAUSES += ["STATUS_TIMEOUT", "SHUTDOWN", "DC_LINK_HIGH"]


@pytest.mark.parametrize(
    ("group", "signal", "texts"),
    [
        ("telemetry", "state", STATES),
        ("drive_state", "state", STATES),
        ("waveform", "state", STATES),
        ("telemetry", "derating_cause", CAUSES),
        ("statistics", "policy", list(enumerators("SchedulingKind"))),
        ("can/MCU_Capability", "DeratingCause", CAUSES),
        ("telemetry", "sector", []),
        ("can/Unknown", "Signal", []),
        ("plant", "state", []),
    ],
)
def test_the_contracts_name_the_values(group: str, signal: str, texts: list[str]) -> None:
    assert value_texts(group, signal) == dict(enumerate(texts))


def test_asammdf_shows_the_names(tmp_path: Path) -> None:
    """In two blocks, of which the second one is appended; a value that the contract does not name is no text."""
    group, path = group_of("telemetry"), tmp_path / "run.mf4"
    rows = np.zeros(len(CAUSES), group.dtype)
    rows["t_ns"] = 1_000_000 * np.arange(len(rows))
    left = len(CAUSES) - len(STATES)
    rows["state"], rows["derating_cause"] = [*range(len(STATES)), *[0] * left], range(len(CAUSES))
    sink = open_sink(path, {})
    sink.add(group)
    sink.append("telemetry", rows[:4])
    sink.append("telemetry", rows[4:])
    sink.close({})
    with MDF(path) as file:
        for signal, names in (("state", [*STATES, *["INIT"] * left]), ("derating_cause", CAUSES)):
            assert [text.decode() for text in file.get(signal).samples.tolist()] == names
            np.testing.assert_array_equal(file.get(signal, raw=True).samples, rows[signal])


def test_values_without_a_name_stay_numbers(tmp_path: Path) -> None:
    source = made(31)
    write(source, tmp_path / "run.mf4")
    assert_same(reread(tmp_path / "run.mf4"), source)
