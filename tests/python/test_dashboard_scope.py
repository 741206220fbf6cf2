"""The scope of the dashboard's page: captures of a waveform whose instants are known, read only while a scope is on."""

import itertools
import json
import struct
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from page_client import DashboardProcess, PageClient, wait_for
from sextant_py import dds, telemetry_types
from sextant_py.dashboard import layout, scope_feed
from sextant_py.errors import UserError
from topic_writer import Writer
from tornado import httpclient
from waveform_writer import PERIOD_NS, STEP_NM, WaveformWriter

SETTINGS = {"trigger": "step 5", "mode": "normal", "before_ms": 5, "after_ms": 15, "hold_off_ms": 0}


def telemetry_writer(domain: int) -> Writer:
    kind = telemetry_types.struct("DriveTelemetry")
    return Writer(domain, dds.TELEMETRY, kind, dds.streaming_qos(1), drive_id=7)


def test_every_panel_of_a_capture_is_of_the_contract() -> None:
    described = {panel["key"]: panel for panel in layout.described(layout.WAVEFORM)}
    assert described["scope_torque"]["unit"] == "N·m"
    assert described["scope_duty"]["lines"][2]["signal"] == "duty_c"
    assert {"t_ns", "switch_state", "torque_nm"} <= set(scope_feed.columns())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"trigger": "stepp 5"}, 'the trigger "stepp 5" is not known'),
        ({"trigger": "rise i_x 5"}, 'the waveform has no signal "i_x"'),
        ({"mode": "burst"}, 'the mode "burst" of the scope'),
        ({"after_ms": 996}, "captures at most 1 s"),
        ({"before_ms": -1}, "must be from 0"),
        ({"before_ms": "5"}, "must be numbers"),
        ({"before_ms": None}, "must be numbers"),
        ({"before_ms": 0, "after_ms": 0}, "nothing to capture"),
    ],
)
def test_wrong_settings_are_one_sentence(change: dict, said: str) -> None:
    with pytest.raises(UserError, match=said.replace("(", r"\(")) as error:
        scope_feed.settings_of({**SETTINGS, **change})
    assert str(error.value).count("\n") == 0


def test_times_beyond_every_number_are_refused(domain: int, tmp_path: Path) -> None:
    huge = "1" + "0" * 400
    with DashboardProcess(domain, tmp_path) as process, telemetry_writer(domain), PageClient(process.socket) as page:
        page.until(lambda m: m["type"] == "status" and m["drives"])
        page.send({"type": "watch", "drive": 7})
        for name in ("before_ms", "after_ms", "hold_off_ms"):
            for value in (huge, f"-{huge}", "NaN"):
                settings = {**SETTINGS, "type": "scope", "on": True, name: 0}
                page.send(json.dumps(settings).replace(f'"{name}": 0', f'"{name}": {value}'))
                assert page.message("scope_refused")["text"].endswith("."), (name, value)


def capture_of(page: PageClient) -> tuple[dict, dict[str, np.ndarray]]:
    """The next capture: what is said of it, and its columns."""
    said = page.message("capture")
    while not isinstance(data := page.receive(), bytes) or data[0] != 2:
        pass
    kind, number, columns, rows = struct.unpack_from("<4I", data)
    assert (kind, number) == (2, said["number"])
    table = np.frombuffer(data, "<f8", offset=16).reshape(columns, rows)
    return said, dict(zip(scope_feed.columns(), table, strict=True))


def test_a_page_is_shown_captures_and_the_drive_is_read_only_meanwhile(domain: int, tmp_path: Path) -> None:
    with (
        DashboardProcess(domain, tmp_path) as process,
        telemetry_writer(domain),
        WaveformWriter(domain) as writer,
        PageClient(process.socket) as page,
    ):
        page.until(lambda m: m["type"] == "status" and m["drives"])
        assert writer.readers() == 0
        page.send({"type": "watch", "drive": 7})
        page.send({"type": "scope", "on": True, **SETTINGS})
        locus = page.message("locus")
        assert locus["switch_state"] == 6
        assert np.hypot(locus["alpha"], locus["beta"]) == pytest.approx(1.0, abs=1e-4)
        said, rows = capture_of(page)
        check(said, rows)
        assert writer.readers() == 1
        check_file(process, said, rows, tmp_path)
        page.send({"type": "scope", "on": False})
        wait_for(lambda: writer.readers() == 0, "the reader's end")
        page.send({"type": "scope", "on": True, **SETTINGS})
        capture_of(page)
        page.close()
        wait_for(lambda: writer.readers() == 0, "the reader's end with the page")


def check(said: dict, rows: dict[str, np.ndarray]) -> None:
    assert said["trigger"] == "step 5"
    assert (said["rows"], said["missing"]) == (801, 0)
    np.testing.assert_array_equal(rows["t_ns"], PERIOD_NS * np.arange(-200, 601))
    step = np.abs(np.diff(rows["torque_reference_nm"]))
    assert np.flatnonzero(step).tolist() == [199], "the step is at time zero"
    assert step[199] == STEP_NM


def check_file(process: DashboardProcess, said: dict, rows: dict[str, np.ndarray], folder: Path) -> None:
    client = httpclient.HTTPClient()
    found = client.fetch(f"{process.address}captures/{said['number']}.h5")
    assert f'filename="capture_{said["number"]:03}.h5"' in found.headers["Content-Disposition"]
    missing = client.fetch(f"{process.address}captures/999.h5", raise_error=False)
    assert missing.code == 404
    client.close()
    path = folder / "capture.h5"
    path.write_bytes(found.body)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["waveform/torque_reference_nm"], rows["torque_reference_nm"])
        times = np.asarray(file["waveform/t_ns"])
    np.testing.assert_array_equal(times - times[200], rows["t_ns"])


def test_lost_batches_are_counted(domain: int, tmp_path: Path) -> None:
    with (
        DashboardProcess(domain, tmp_path) as process,
        telemetry_writer(domain),
        WaveformWriter(domain, without=range(50, 10_000, 10)),
        PageClient(process.socket) as page,
    ):
        page.until(lambda m: m["type"] == "status" and m["drives"])
        page.send({"type": "watch", "drive": 7})
        page.send({"type": "scope", "on": True, **SETTINGS, "trigger": "fault"})
        report = page.until(lambda m: m["type"] == "scope" and m["lost"] >= 3)
    assert report["state"] == "waiting"
    assert report["rows"] > 0


def test_captures_do_not_queue_for_a_page_that_reads_too_slowly(domain: int, tmp_path: Path) -> None:
    with (
        DashboardProcess(domain, tmp_path) as process,
        telemetry_writer(domain),
        WaveformWriter(domain),
        PageClient(process.socket) as page,
    ):
        page.until(lambda m: m["type"] == "status" and m["drives"])
        page.send({"type": "watch", "drive": 7})
        page.send({"type": "scope", "on": True, **SETTINGS, "after_ms": 900})
        number = itertools.count()
        page.until(lambda m: m["type"] == "scope" and m["unshown"] > 0, lambda: next(number) % 300 or time.sleep(4.0))
        page.message("capture")
