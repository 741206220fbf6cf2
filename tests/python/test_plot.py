"""Pictures of traces and recordings: overview, chosen signals, spectra, loci, layouts; and what a bad call is told."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_recording import write_cut
from sextant_py import plot, signal_file
from sextant_py.errors import UserError
from sextant_py.plots import html, lanes, locus, marks, overview, panels, png, points, series, spectrum, styles
from sextant_py.recording.formats import open_sink
from sextant_py.recording.topics import STATE, WAVEFORM, group_of

PNG = b"\x89PNG\r\n\x1a\n"


def write_trace(path: Path, count: int, time_name: str) -> None:
    t_s = np.linspace(0, 1, count)
    with h5py.File(path, "w") as file:
        file["t_ns" if time_name == "t_ns" else "t_s"] = (
            (t_s * 1e9).astype(np.int64) + 7_000_000_000 if time_name == "t_ns" else t_s
        )
        for name, value in {
            "torque_requested_nm": 15 * np.sign(t_s - 0.5),
            "torque_reference_nm": 15 * np.sign(t_s - 0.5),
            "torque_mean_nm": 15 * np.tanh(20 * (t_s - 0.5)),
            "torque_min_nm": 15 * np.tanh(20 * (t_s - 0.5)) - 3,
            "torque_max_nm": 15 * np.tanh(20 * (t_s - 0.5)) + 3,
            "flux_mean_wb": np.full(count, 1.1),
            "speed_rad_s": 30 * t_s,
            "current_mean_a": np.full(count, 20.0),
        }.items():
            file[name] = value


@pytest.mark.parametrize(("count", "time_name"), [(500, "t_s"), (50_000, "t_ns")])
def test_picture_is_written(tmp_path: Path, count: int, time_name: str) -> None:
    write_trace(tmp_path / "trace.h5", count, time_name)
    assert plot.main([str(tmp_path / "trace.h5")]) == 0
    picture = (tmp_path / "trace.png").read_bytes()
    assert picture.startswith(PNG)
    assert len(picture) > 20_000


def test_the_overview_has_reference_and_band(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    torque, flux, speed, current = overview.arrange(load(tmp_path / "trace.h5")[0])
    assert [line.name for line in torque.lines] == ["torque_nm", "torque_requested_nm", "torque_reference_nm"]
    assert (torque.lines[0].low.name, torque.lines[0].high.name) == ("torque_min_nm", "torque_max_nm")
    assert [panel.lines[0].series.name for panel in (flux, speed, current)] == [
        "flux_mean_wb",
        "speed_rad_s",
        "current_mean_a",
    ]
    (each, entries) = styles.of_lines(torque.lines)
    assert len({(style.colour, style.dash) for style in each}) == len(entries) == 3


def test_nanoseconds_count_from_the_first_sample(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 101, "t_ns")
    signals = signal_file.load(tmp_path / "trace.h5", 0.25, 0.75)
    assert signals.time_s[0] == pytest.approx(0.25)
    assert signals.time_s[-1] == pytest.approx(0.75)
    assert len(signals.values["torque_mean_nm"]) == len(signals.time_s) == 51


def test_missing_signals_leave_an_empty_panel(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "few.h5", "w") as file:
        file["t_s"] = [0.0, 1.0]
    assert plot.main([str(tmp_path / "few.h5"), "-o", str(tmp_path / "out" / "few.png")]) == 0
    assert (tmp_path / "out" / "few.png").read_bytes().startswith(PNG)


def test_further_signals_have_panels_of_their_own(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    assert overview.further(load(tmp_path / "trace.h5")[0]) == []
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        for leg in "abc":
            file[f"plant/switch_{leg}"] = np.ones(500, dtype=np.int8)
        file["plant/energy_link_j"] = np.linspace(0, 100, 500)
        file["plant/shaft_torque_nm"] = np.linspace(0, 20, 500)
        file["plant/load_speed_rad_s"] = np.linspace(0, 10, 500)
        file["control/torque_comparator"] = -np.ones(500, dtype=np.int8)
    panels = overview.further(load(tmp_path / "trace.h5")[0])
    assert [tuple(line.name for line in panel.lines) for panel in panels] == [
        ("plant/switch_a", "plant/switch_b", "plant/switch_c"),
        ("control/torque_comparator",),
        ("plant/shaft_torque_nm",),
        ("plant/load_speed_rad_s",),
        ("plant/energy_link_j",),
    ]
    assert plot.main([str(tmp_path / "trace.h5")]) == 0
    assert (tmp_path / "trace.png").read_bytes().startswith(PNG)


def test_channels_of_a_controller_are_drawn_by_unit(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        for name, unit in (("i_d_a", b"A"), ("i_q_a", b"A"), ("psi_r_wb", "Wb"), ("without_unit", None)):
            file[f"control/{name}"] = np.linspace(0, 1, 500)
            if unit is not None:
                file[f"control/{name}"].attrs["unit"] = unit
    panels = overview.further(load(tmp_path / "trace.h5")[0])
    assert [tuple(line.name for line in panel.lines) for panel in panels] == [
        ("control/i_d_a", "control/i_q_a"),
        ("control/psi_r_wb",),
        ("control/without_unit",),
    ]
    assert plot.main([str(tmp_path / "trace.h5")]) == 0


def test_bad_files(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not exist"):
        signal_file.load(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(UserError, match="is not an HDF5 file"):
        signal_file.load(tmp_path / "text.h5")
    with h5py.File(tmp_path / "empty.h5", "w"):
        pass
    with pytest.raises(UserError, match="has no signals with a time axis"):
        signal_file.load(tmp_path / "empty.h5")
    write_trace(tmp_path / "trace.h5", 11, "t_s")
    with pytest.raises(UserError, match="no sample in that span"):
        signal_file.load(tmp_path / "trace.h5", 5.0)


TONES = ((50.0, 12.0), (1850.0, 0.75))  # [Hz, N·m]


def write_waves(path: Path, count: int = 8000, period_s: float = 25e-6) -> None:
    """A machine at 50 Hz: torque with two tones, phase currents of 10 A, flux of 1.1 Wb, a sector, a counter."""
    t_s = period_s * np.arange(count)
    angle = 2 * np.pi * 50 * t_s
    torque = 20.0 + sum(amplitude * np.cos(2 * np.pi * hz * t_s + 0.3) for hz, amplitude in TONES)
    with h5py.File(path, "w") as file:
        for name, values, unit in (
            ("t_ns", np.rint(t_s * 1e9).astype(np.int64), "ns"),
            ("torque_mean_nm", torque, "N·m"),
            ("torque_min_nm", torque - 1, "N·m"),
            ("torque_max_nm", torque + 1, "N·m"),
            ("plant/torque_nm", torque, "N·m"),
            ("i_a_a", 10 * np.cos(angle), "A"),
            ("i_b_a", 10 * np.cos(angle - 2 * np.pi / 3), "A"),
            ("i_c_a", 10 * np.cos(angle + 2 * np.pi / 3), "A"),
            ("plant/psi_s_alpha_wb", 1.1 * np.cos(angle), "Wb"),
            ("plant/psi_s_beta_wb", 1.1 * np.sin(angle), "Wb"),
            ("sector", (1 + angle / (np.pi / 3) % 6).astype(np.int64), "1"),
            ("periods", 1 + np.arange(count) % 2, "1"),
        ):
            file[name] = values
            file[name].attrs["unit"] = unit


@pytest.fixture
def waves(tmp_path: Path) -> Path:
    write_waves(tmp_path / "waves.h5")
    return tmp_path / "waves.h5"


def load(*paths: Path) -> list[series.SeriesFile]:
    return series.load(list(paths), None, None)


def test_panels_are_chosen_by_unit_and_kind(waves: Path) -> None:
    found = {panel.heading: [line.label for line in panel.lines] for panel in panels.arrange(load(waves), [])}
    assert found == {
        "Torque [N·m]": ["torque_nm"],
        "Flux linkage, components [Wb]": ["plant/psi_s_alpha_wb", "plant/psi_s_beta_wb"],
        "Current, phases [A]": ["i_a_a", "i_b_a", "i_c_a"],
        "States": ["sector"],
    }
    (torque,) = panels.arrange(load(waves), ["torque"])
    assert [line.low.name for line in torque.lines] == ["torque_min_nm"]


@pytest.mark.parametrize(
    ("name", "signals"),
    [
        ("i_a_a", ["i_a_a"]),
        ("i_?_a", ["i_a_a", "i_b_a", "i_c_a"]),
        ("torque", ["torque_mean_nm", "torque_min_nm", "torque_max_nm"]),
        ("torque_nm", ["torque_mean_nm", "torque_min_nm", "torque_max_nm"]),
        ("plant/torque_nm", ["plant/torque_nm"]),
        ("psi_s_beta_wb", ["plant/psi_s_beta_wb"]),
        ("psi_s_beta", ["plant/psi_s_beta_wb"]),
    ],
)
def test_names_of_signals(waves: Path, name: str, signals: list[str]) -> None:
    (file,) = load(waves)
    assert sorted(found.name for found in file.find(name)) == sorted(signals)


def test_an_unknown_signal_is_told_the_nearest(waves: Path) -> None:
    with pytest.raises(UserError, match=r'has no signal "torqe_mean_nm"; the nearest are .*torque_mean_nm'):
        plot.main([str(waves), "torqe_mean_nm"])
    with pytest.raises(UserError, match=r'has no signal "xyz"; scripts/plot --list shows its signals\.'):
        plot.main([str(waves), "xyz"])


def test_two_files_are_drawn_over_each_other(waves: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_waves(tmp_path / name / "trace.h5", 4000)
    files = [tmp_path / "a" / "trace.h5", tmp_path / "b" / "trace.h5"]
    assert series.labels(files) == ["a", "b"]
    assert series.labels(files[:1]) == ["a"], "a trace alone has the name of its run"
    (panel,) = panels.arrange(load(*files), ["sector"])
    assert [line.label for line in panel.lines] == ["sector, a", "sector, b"]
    assert plot.main([*map(str, files), "torque", "i_?_a", "-o", str(tmp_path / "two.png")]) == 0
    assert (tmp_path / "two.png").read_bytes().startswith(PNG)
    # A signal that one of the files lacks is drawn of the other.
    (panel,) = panels.arrange(load(waves, files[0]), ["sector"])
    assert len(panel.lines) == 2


def test_bands_keep_every_peak_and_the_mean() -> None:
    rng = np.random.default_rng(7)
    values = rng.normal(size=30_011)
    values[[5, 17_000]] = 40, -30
    time_s, mean, low, high = points.bands(np.arange(len(values)) / 1e3, values, values, values, 1000)
    assert len(time_s) == len(mean) == 1000
    assert (high.max(), low.min()) == (40, -30)
    assert np.all((low <= mean) & (mean <= high))
    assert np.average(mean) == pytest.approx(values.mean(), abs=0.01)
    values[100:200] = np.nan
    _, mean, low, high = points.bands(np.arange(len(values)) / 1e3, values, values, values, 1000)
    assert np.isnan(mean).sum() == np.isnan(low).sum() <= 4
    time_s, drawn = points.envelope(np.arange(30_011.0), values, 1000)
    assert len(drawn) <= 1000
    assert (np.nanmax(drawn), np.nanmin(drawn)) == (40, -30)


@pytest.mark.parametrize("window", plot.WINDOWS)
def test_a_spectrum_has_the_amplitudes_of_the_tones(waves: Path, window: str) -> None:
    """Against a least-squares fit of the tones, which knows nothing of windows or transforms."""
    (found,) = spectrum.compute(load(waves), ["plant/torque_nm"], window)
    torque = load(waves)[0].series["plant/torque_nm"]
    columns = [wave(2 * np.pi * hz * torque.time_s) for hz, _ in TONES for wave in (np.cos, np.sin)]
    fit = np.linalg.lstsq(np.column_stack([*columns, np.ones(len(torque.time_s))]), torque.values, rcond=None)[0]
    for number, (hz, _) in enumerate(TONES):
        line = np.abs(found.frequency_hz - hz).argmin()
        assert found.frequency_hz[line] == pytest.approx(hz)
        assert found.amplitude[line] == pytest.approx(np.hypot(*fit[2 * number : 2 * number + 2]), rel=1e-6)
    assert found.amplitude[0] == pytest.approx(20.0, rel=1e-3)
    assert (found.unit, len(found.frequency_hz)) == ("N·m", 4001)


def test_a_spectrum_of_uneven_samples_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "gap.h5", "w") as file:
        t_ns = 1_000_000 * np.arange(200)
        file["t_ns"] = np.delete(t_ns, 100)
        file["torque_nm"] = np.zeros(199)
    with pytest.raises(UserError, match=r"torque_nm are not evenly spaced at 0\.099 s"):
        plot.main([str(tmp_path / "gap.h5"), "torque_nm", "--spectrum"])
    assert plot.main([str(tmp_path / "gap.h5"), "torque_nm", "--spectrum", "--to", "0.05"]) == 0
    with pytest.raises(UserError, match="has 6 samples in the span; a spectrum needs 16"):
        plot.main([str(tmp_path / "gap.h5"), "torque_nm", "--spectrum", "--to", "0.005"])


def test_the_last_row_of_a_trace_may_come_early(waves: Path) -> None:
    (whole,) = spectrum.compute(load(waves), ["torque_mean_nm"], "hann")
    with h5py.File(waves, "a") as file:
        for name in list(file):
            if isinstance(data := file[name], h5py.Dataset):
                longer = np.append(data[()], data[-1])
                unit = data.attrs["unit"]
                del file[name]
                file[name] = longer
                file[name].attrs["unit"] = unit
        file["t_ns"][-1] += 10_000
    (found,) = spectrum.compute(load(waves), ["torque_mean_nm"], "hann")
    np.testing.assert_array_equal(found.amplitude, whole.amplitude)


def test_spectra_without_names_are_of_torque_and_phase_currents(waves: Path) -> None:
    found = spectrum.compute(load(waves), [], "hann")
    assert sorted(one.label for one in found) == ["i_a_a", "i_b_a", "i_c_a", "plant/torque_nm", "torque_mean_nm"]


def test_a_page_shows_the_amplitudes_that_a_picture_does(waves: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pages, pictures = [], []
    monkeypatch.setattr(html, "save", lambda figure, *_: pages.append(figure.layout))
    monkeypatch.setattr(png, "save", lambda figure, _: pictures.append([axes.get_ylim() for axes in figure.axes]))
    found = spectrum.compute(load(waves), [], "hann")
    spectrum.draw_html(found, "", Path())
    spectrum.draw_png(found, "", Path())
    shown = [pages[0][axis]["range"] for axis in ("yaxis", "yaxis2")]
    np.testing.assert_allclose(10.0 ** np.array(shown), pictures[0])


def test_lines_next_to_zero_frequency_are_not_on_the_axis(waves: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    monkeypatch.setattr(png, "save", lambda figure, _: drawn.append([axes.get_xlim() for axes in figure.axes]))
    spectrum.draw_png(spectrum.compute(load(waves), [], "hann"), "", Path())
    assert all(left < 0 for left, _ in drawn[0])
    monkeypatch.setattr(html, "save", lambda figure, *_: drawn.append(figure.layout.xaxis.range))
    spectrum.draw_html(spectrum.compute(load(waves), [], "hann"), "", Path())
    assert drawn[1][0] < 0


def test_loci_are_circles_in_the_direction_of_the_field(waves: Path) -> None:
    (file,) = load(waves)
    for quantity, radius in (("flux", 1.1), ("current", 10.0)):
        alpha, beta = locus.components(file, quantity)
        np.testing.assert_allclose(np.hypot(alpha, beta), radius, rtol=1e-12)
        assert np.all(np.diff(np.unwrap(np.arctan2(beta, alpha))) > 0)
        assert alpha[0] == pytest.approx(radius)


def test_the_flux_of_a_recording_is_of_magnitude_and_angle(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "recording.h5", "w") as file:
        file["t_ns"] = 1_000_000 * np.arange(50)
        file["flux_mean_wb"] = np.full(50, 0.9)
        file["flux_angle_rad"] = 0.1 * np.arange(50)
    (loci,) = locus.compute(load(tmp_path / "recording.h5"), "flux")
    np.testing.assert_allclose(loci.alpha + 1j * loci.beta, 0.9 * np.exp(0.1j * np.arange(50)))
    with pytest.raises(UserError, match="has no signals of the stator current"):
        plot.main([str(tmp_path / "recording.h5"), "--locus", "current"])


def write_capture(path: Path, *others: str, **counts: int) -> None:
    """400 control periods, with one row of other groups or with these counts."""
    sink = open_sink(path, {})
    for name, count in {**dict.fromkeys(others, 1), WAVEFORM: 400, **counts}.items():
        rows = np.zeros(count, group_of(name).dtype)
        rows["t_ns"] = 10**9 + 25_000 * np.arange(count)
        if name == WAVEFORM:
            angle = 0.05 * np.arange(count)
            rows["torque_nm"], rows["flux_alpha_wb"], rows["flux_beta_wb"] = 15, np.cos(angle), np.sin(angle)
            rows["sector"] = 1 + angle // (np.pi / 3) % 6
        sink.add(group_of(name))
        sink.append(name, rows)
    sink.close({})


@pytest.mark.parametrize("suffix", [".h5", ".mcap"])
def test_groups_without_rows_are_passed_over(tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / f"capture{suffix}"
    write_capture(path, drive_state=0, telemetry=0)
    assert plot.main([str(path)]) == 0
    assert plot.main([str(path), "-o", str(tmp_path / "page.html")]) == 0
    assert plot.main([str(path), "--list"]) == 0
    said = capsys.readouterr().out
    assert "drive_state: no samples\n" in said
    assert "waveform: 400 samples from 0 s" in said
    write_capture(path, drive_state=0, waveform=0)
    with pytest.raises(UserError, match=r"has no samples of (drive_state, waveform|waveform, drive_state)"):
        plot.main([str(path)])


@pytest.mark.parametrize("suffix", [".h5", ".mcap"])
def test_control_periods_of_a_recording_and_of_a_capture(tmp_path: Path, suffix: str) -> None:
    recording, capture = tmp_path / f"recording{suffix}", tmp_path / f"capture{suffix}"
    write_capture(recording, "telemetry")
    write_capture(capture)
    (torque, sector) = panels.arrange(load(recording), ["waveform/torque_nm", "waveform/sector"])
    assert [len(panel.lines[0].series.values) for panel in (torque, sector)] == [400, 400]
    assert torque.lines[0].series.time_s[-1] == pytest.approx(399 * 25e-6)
    headings = [panel.heading for panel in panels.arrange(load(capture), [])]
    assert {"Torque [N·m]", "Flux linkage, components [Wb]", "States"} <= set(headings)
    for path in (recording, capture):
        (loci,) = locus.compute(load(path), "flux")
        np.testing.assert_allclose(np.hypot(loci.alpha, loci.beta), 1, rtol=1e-6)
    assert plot.main([str(capture)]) == 0
    assert (tmp_path / "capture.png").read_bytes().startswith(PNG)


TRIP_S, OPEN_PHASE, WATCHDOG = 0.005, 15, 18


def write_trip(path: Path, trigger: str | None = "fault") -> None:
    """As scripts/scope writes it: 400 control periods about a trip, 3 of them missing, the state before and after."""
    begin_ns = 10**9
    trip_ns = begin_ns + int(TRIP_S * 1e9)
    metadata = {} if trigger is None else {"trigger": trigger, "trigger_ns": trip_ns, "main": WAVEFORM}
    rows = np.zeros(400, group_of(WAVEFORM).dtype)
    rows["t_ns"] = begin_ns + 25_000 * np.arange(400)
    rows["t_ns"][300:] += 75_000
    rows["period_ns"] = 25_000
    rows["torque_nm"] = 15
    rows["state"] = np.where(rows["t_ns"] < trip_ns, 4, 6)
    rows["state"][:40] = 3
    changes = np.zeros(2, group_of(STATE).dtype)
    changes["t_ns"] = trip_ns, trip_ns + 1_000_000
    changes["state"] = 6
    changes["faults_latched"] = 1 << OPEN_PHASE, 1 << OPEN_PHASE | 1 << WATCHDOG
    changes["faults_active"] = changes["faults_latched"]
    sink = open_sink(path, metadata)
    for name, block in ((WAVEFORM, rows), (STATE, changes)):
        sink.add(group_of(name))
        sink.append(name, block)
    sink.close(metadata)


@pytest.mark.parametrize("suffix", [".h5", ".mcap"])
@pytest.mark.parametrize("trigger", ["fault", None])
def test_a_capture_of_a_fault_draws_the_waveform(tmp_path: Path, suffix: str, trigger: str | None) -> None:
    path = tmp_path / f"capture{suffix}"
    write_trip(path, trigger)
    (file,) = load(path)
    headings = {panel.heading: [line.name for line in panel.lines] for panel in panels.arrange([file], [])}
    assert headings["Torque [N·m]"] == ["torque_requested_nm", "torque_reference_nm", "torque_nm"]
    assert headings["States"] == ["state"]
    assert not any("faults_active" in name for names in headings.values() for name in names)
    assert plot.main([str(path)]) == 0


def test_marks_are_named_and_stand_at_their_times(tmp_path: Path) -> None:
    write_trip(tmp_path / "trip.h5")
    found = marks.of(load(tmp_path / "trip.h5"))
    expected = [  # seconds from the trigger
        (marks.MAGNETISING, -TRIP_S, -TRIP_S + 40 * 25e-6, "magnetising"),
        (marks.FAULT, 0.0, None, "OPEN_PHASE"),
        (marks.TRIGGER, 0.0, None, "trigger: fault"),
        (marks.FAULT, 1e-3, None, "WATCHDOG"),
        (marks.LATE, 299 * 25e-6 - TRIP_S, 303 * 25e-6 - TRIP_S, "periods without a row: 3"),
    ]
    assert [(mark.kind, mark.text) for mark in found] == [(kind, text) for kind, _, _, text in expected]
    for mark, (_, begin_s, end_s, _) in zip(found, expected, strict=True):
        assert mark.begin_s == pytest.approx(begin_s, abs=1e-9)
        assert mark.end_s == (None if end_s is None else pytest.approx(end_s, abs=1e-9))
    assert [text for _, text in marks.texts(found, 0.01)] == [
        "magnetising",
        "OPEN_PHASE, trigger: fault",
        "WATCHDOG",
        "periods without a row: 3",
    ]
    later = marks.within(found, -TRIP_S + 0.5e-3, 0.5e-3)
    assert [(mark.kind, mark.text) for mark in later] == [(kind, text) for kind, _, _, text in expected[:3]]
    assert later[0].begin_s == -TRIP_S + 0.5e-3


def test_many_late_wake_ups_share_one_text_and_leave_faults_theirs() -> None:
    late = [marks.Mark(marks.LATE, float(k), k + 0.5, f"late wake-ups: {k}") for k in range(20)]
    fault = marks.Mark(marks.FAULT, 10.2, None, "OPEN_PHASE")
    assert [text for _, text in marks.texts([*late[:11], fault, *late[11:]], 20.0)] == [
        "late wake-ups or gaps at 20 times",
        "OPEN_PHASE",
    ]
    assert len(marks.texts(late[: marks.MOST_LATE], 20.0)) == marks.MOST_LATE


def test_texts_of_marks_are_not_on_bands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_trip(tmp_path / "trip.h5")
    arranged = panels.arrange(load(tmp_path / "trip.h5"), ["state", "torque_nm"])
    assert [panel.is_discrete for panel in arranged] == [True, False]
    found = marks.of(load(tmp_path / "trip.h5"))
    states, torque = ([text.get_text() for text in axes.texts] for axes in png.figure_of(arranged, "", found).axes)
    assert "magnetising" in torque
    assert "magnetising" not in states
    pages = []
    monkeypatch.setattr(html, "save", lambda figure, *_: pages.append(figure.layout.annotations))
    html.draw(arranged, "", Path(), found)
    assert {note.yref for note in pages[0] if note.text == "magnetising"} == {"y2 domain"}


def test_duty_cycles_have_a_heading(tmp_path: Path) -> None:
    assert panels.heading("1", "phases") == "Pure numbers, phases"
    assert panels.heading("1", "states") == "States"
    assert panels.heading("A", "phases") == "Current, phases [A]"


def test_a_trace_without_changes_of_state_marks_its_trip(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 100, "t_ns")
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        file["state"] = np.repeat(np.array([3, 4, 6], np.uint8), (20, 40, 40))
    (file,) = load(tmp_path / "trace.h5")
    assert [(mark.kind, mark.text) for mark in marks.of([file])] == [
        (marks.MAGNETISING, "magnetising"),
        (marks.FAULT, "FAULT"),
    ]
    assert marks.of([file])[1].begin_s == pytest.approx(60 / 99)
    assert overview.further(file)[-1].lines[0].name == "state"


def test_late_wake_ups_of_the_statistics_are_marked(tmp_path: Path) -> None:
    rows = np.zeros(4, group_of("statistics").dtype)
    rows["t_ns"], rows["overruns"] = 10**9 * np.arange(4), (5, 5, 8, 8)
    sink = open_sink(tmp_path / "statistics.h5", {})
    sink.add(group_of("statistics"))
    sink.append("statistics", rows)
    sink.close({})
    assert marks.of(load(tmp_path / "statistics.h5")) == [marks.Mark(marks.LATE, 1.0, 2.0, "late wake-ups: 3")]


@pytest.mark.parametrize("values", [[3] * 20 + [4] * 40 + [6] * 40, [4] * 100, [0] * 99 + [6]])
def test_enumerations_are_bands_with_names(tmp_path: Path, figures: list, values: list[int]) -> None:
    names = {0: "INIT", 3: "MAGNETISING", 4: "TORQUE", 6: "FAULT"}
    write_trace(tmp_path / "trace.h5", 100, "t_ns")
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        file["state"], file["sector"] = np.array(values, np.uint8), np.arange(100) // 17 + 1
    assert plot.main([str(tmp_path / "trace.h5"), "state", "sector"]) == 0
    (axes,) = figures[0].axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["state", "sector (1…6)"]
    runs = [value for place, value in enumerate(values) if place == 0 or value != values[place - 1]]
    drawn = [text.get_text() for text in axes.texts] + [
        text.get_text() for legend in (axes.get_legend(),) if legend for text in legend.get_texts()
    ]
    assert {names[value] for value in runs} <= set(drawn)
    lane = lanes.of(panels.arrange(load(tmp_path / "trace.h5"), ["state"])[0].lines)[0]
    bands = lane.bands()
    assert [band.text for band in bands] == [names[value] for value in runs]
    assert [band.begin_s for band in bands[1:]] == [band.end_s for band in bands[:-1]]
    assert (bands[0].begin_s, bands[-1].end_s) == (0.0, 1.0)


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list:
    """Pictures instead of their files."""
    kept: list = []
    monkeypatch.setattr(png, "save", lambda figure, _: kept.append(figure))
    return kept


def test_legends_stay_short(tmp_path: Path, figures: list) -> None:
    """Of several files one entry for each signal and each file, and of very many lines the first."""
    paths = [tmp_path / name / "trace.h5" for name in "abc"]
    for path in paths:
        path.parent.mkdir()
        write_waves(path, 100)
        with h5py.File(path, "a") as file:
            for number in range(20):
                file[f"plant/branch_{number}_v"] = np.arange(100.0)
                file[f"plant/branch_{number}_v"].attrs["unit"] = "V"
    assert plot.main([*map(str, paths), "i_?_a"]) == 0
    assert plot.main([*map(str, paths[:2]), "plant/branch_*"]) == 0
    few, many = (figure.axes[0].get_legend().get_texts() for figure in figures)
    assert [text.get_text() for text in few] == ["i_a_a", "i_b_a", "i_c_a", "a", "b", "c"]
    assert [text.get_text() for text in many][-1] == "… 27 more"
    assert len(many) == png.MOST_ENTRIES
    looks = {(line.get_color(), line.get_linestyle()) for line in figures[0].axes[0].lines}
    assert len(looks) == 9


def test_what_a_truncated_file_lost_is_told(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    write_cut(tmp_path / "cut.csv")
    assert plot.main([str(tmp_path / "cut.csv")]) == 0
    assert capsys.readouterr().err.startswith(f"plot: {tmp_path / 'cut.csv'} is truncated: rows that are lost")


@pytest.mark.parametrize("words", [[], ["torque", "sector"], ["--spectrum"], ["--locus", "flux"]])
def test_pages_need_no_network(waves: Path, tmp_path: Path, words: list[str]) -> None:
    page = tmp_path / "page.html"
    assert plot.main([str(waves), *words, "-o", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "plotly.js v" in text  # the script itself
    assert text.startswith("<!doctype html>")
    assert re.search(r"<title>waves\.h5.*</title>", text)
    assert re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=[^>]*>", text) == []


@pytest.mark.parametrize("words", [["--spectrum"], ["--locus", "flux"], ["--locus", "current"], ["sector", "i_?_a"]])
def test_pictures_of_each_kind_have_a_name_of_their_own(waves: Path, words: list[str]) -> None:
    assert plot.main([str(waves), *words]) == 0
    kind = {"--spectrum": ".spectrum", "--locus": f".{words[-1]}_locus"}.get(words[0], "")
    assert waves.with_suffix(f"{kind}.png").read_bytes().startswith(PNG)


def test_layouts_of_the_paper(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        file["plant/tau_l_nm"] = np.full(500, 3.0)
    trace = str(tmp_path / "trace.h5")
    for name in ("9", "10", "13", "15"):
        assert plot.main([trace, trace.replace("trace.h5", "./trace.h5"), "--figure", name]) == 0
        assert (tmp_path / f"trace.figure_{name}.png").read_bytes().startswith(PNG)
    with pytest.raises(UserError, match=r"--figure 12: .* lacks current_max_a, i_a_a, i_b_a, i_c_a\."):
        plot.main([trace, "--figure", "12"])
    with pytest.raises(UserError, match='no layout is called "7"; known are 9, 10,'):
        plot.main([trace, "--figure", "7"])
    capsys.readouterr()
    assert plot.main(["--figure", "list"]) == 0
    assert " 13  torque and speed of reversals" in capsys.readouterr().out


def test_the_list_of_signals(waves: Path, capsys: pytest.CaptureFixture) -> None:
    assert plot.main([str(waves), "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == [str(waves), "telemetry: 8000 samples from 0 s to 0.199975 s"]
    assert ["torque_mean_nm", "N·m"] in [line.split() for line in lines]
    assert len(lines) == 14


@pytest.mark.parametrize(
    ("words", "said"),
    [(["-o", "x.txt"], "expected the ending .png, .svg, .pdf or .html"), (["--from", "9"], "no sample in that span")],
)
def test_bad_calls(waves: Path, words: list[str], said: str) -> None:
    with pytest.raises(UserError, match=said):
        plot.main([str(waves), *words])


def test_a_call_without_a_file_says_what_a_file_is(capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit) as ended:
        plot.main(["torque_mean_nm"])
    assert ended.value.code == 2
    assert (
        'expected a file that ends in .h5, .csv, .mcap, .mf4, .parquet, and "torque_mean_nm" is none'
        in capsys.readouterr().err
    )
