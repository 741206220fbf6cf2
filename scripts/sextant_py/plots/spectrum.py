"""Amplitude spectra of signals, single-sided, in the signal's unit over frequency."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import signal as scipy_signal

from ..errors import UserError
from . import html, png
from .panels import heading, kind_of
from .points import envelope
from .series import Series, SeriesFile

UNEVEN = 0.01  # share of the mean distance by which samples may lie off an even grid
FEWEST = 16
FLOOR = 1e-6  # of the largest amplitude: what lies below is not shown
MARGIN = 0.01  # of the frequencies on either side, where the lines next to zero are not on the axis


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes (peak) over frequency."""

    label: str
    unit: str
    frequency_hz: np.ndarray
    amplitude: np.ndarray
    about: str


def of_series(series: Series, window: str) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and amplitudes. A sine of a whole number of periods has its peak value as its line's."""
    values, steps = series.values.astype(float), np.diff(series.time_s)
    if len(values) < FEWEST:
        raise UserError(f"{series.name} has {len(values)} samples in the span; a spectrum needs {FEWEST}.")
    # The last row of a trace ends with the run, which may be before the end of its interval.
    if steps[-1] < (1 - UNEVEN) * np.median(steps):
        values, steps = values[:-1], steps[:-1]
    step_s = float(steps.mean())
    if np.abs(steps - step_s).max() > UNEVEN * step_s:
        place_s = series.time_s[int(np.abs(steps - step_s).argmax())]
        raise UserError(
            f"the samples of {series.name} are not evenly spaced at {place_s:.6g} s, which a spectrum needs; "
            "--from and --to choose a span without a gap."
        )
    if not np.isfinite(values).all():
        raise UserError(f"{series.name} has samples without a value in the span; --from and --to choose another.")
    frequency, power = scipy_signal.periodogram(values, 1 / step_s, window, detrend=False, scaling="spectrum")
    amplitude = np.sqrt(2 * power)
    amplitude[0] = np.sqrt(power[0])
    if len(values) % 2 == 0:
        amplitude[-1] = np.sqrt(power[-1])
    return frequency, amplitude


def choose(file: SeriesFile) -> list[Series]:
    """Torque and phase currents, of the drive where it has them; and the plant's torque, which has the ripple within a
    control period."""
    wanted = []
    for name, series in file.series.items():
        if name not in file.main:
            continue
        is_phase = series.unit == "A" and kind_of(series) == "phases"
        is_torque = series.unit == "N·m" and series.quantity.rpartition("/")[2] == "torque_nm"
        if (is_phase or is_torque) and not series.name.endswith(("_min_nm", "_max_nm")):
            wanted.append(series)
    own = {series.quantity for series in wanted if "/" not in series.name}
    # Of the plant's torque the samples alone, which the mean of a row is close to.
    samples = [series for series in wanted if series.unit == "N·m" and series.name == series.quantity]
    return [s for s in wanted if "/" not in s.name or s in samples or s.quantity.rpartition("/")[2] not in own]


def compute(files: list[SeriesFile], wanted: list[str], window: str) -> list[Spectrum]:
    found = []
    for file in files:
        chosen = [series for name in wanted for series in file.find(name)] if wanted else choose(file)
        for series in {series.name: series for series in chosen}.values():
            frequency, amplitude = of_series(series, window)
            label = f"{series.name}, {file.label}" if len(files) > 1 else series.name
            about = f"{frequency[1]:.3g} Hz a line, {window} window"
            found.append(Spectrum(label, series.unit, frequency, amplitude, about))
    if not found:
        raise UserError(f"{files[0].path} has neither torque nor phase currents; name the signals of the spectrum.")
    return found


def _by_unit(spectra: list[Spectrum]) -> dict[str, list[Spectrum]]:
    units: dict[str, list[Spectrum]] = {}
    for spectrum in spectra:
        units.setdefault(spectrum.unit, []).append(spectrum)
    return units


def _heading(unit: str) -> str:
    return f"{heading(unit, '')}, amplitude (peak)"


def _abscissa(spectra: list[Spectrum]) -> str:
    return "Frequency [Hz]; " + "; ".join(dict.fromkeys(spectrum.about for spectrum in spectra))


def _span(part: list[Spectrum]) -> tuple[float, float] | None:
    """The amplitudes that a panel shows; None where all are zero."""
    largest = max(float(spectrum.amplitude.max()) for spectrum in part)
    smallest = min(float(np.median(spectrum.amplitude)) for spectrum in part)
    return (max(smallest / 30, FLOOR * largest), 2 * largest) if largest > 0 else None


def draw_png(spectra: list[Spectrum], title: str, output: Path) -> None:
    units = _by_unit(spectra)
    figure, grid = png.sheet(len(units), title, sharex=True)
    for axes, (unit, part) in zip(grid, units.items(), strict=True):
        for number, spectrum in enumerate(part):
            colour, style = png.style_of(number)
            points = envelope(spectrum.frequency_hz, spectrum.amplitude, 2 * png.MOST_POINTS)
            axes.plot(*points, style, color=colour, linewidth=0.9, alpha=0.8, label=spectrum.label)
        if span := _span(part):
            axes.set_yscale("log")
            axes.set_ylim(*span)
        axes.set_title(_heading(unit))
        axes.margins(x=MARGIN)
        png.legend(axes)
    grid[-1].set_xlabel(_abscissa(spectra))
    png.save(figure, output)


def draw_html(spectra: list[Spectrum], title: str, output: Path) -> None:
    units = _by_unit(spectra)
    figure = html.sheet([_heading(unit) for unit in units])
    for row, part in enumerate(units.values(), 1):
        place = {"legend": html.legend_of(row)}
        for number, spectrum in enumerate(part):
            x, y = envelope(spectrum.frequency_hz, spectrum.amplitude, 2 * html.MOST_POINTS)
            shape = html.style_of(number) | {"width": 1.2}
            figure.add_scatter(x=x, y=y, mode="lines", name=spectrum.label, line=shape, row=row, col=1, **place)
        if span := _span(part):
            ends = [math.log10(end) for end in span]
            figure.update_yaxes(type="log", range=ends, exponentformat="power", dtick=1, row=row, col=1)
    last = max(float(spectrum.frequency_hz[-1]) for spectrum in spectra)
    figure.update_xaxes(range=[-MARGIN * last, (1 + MARGIN) * last])
    figure.update_xaxes(title_text=_abscissa(spectra), row=len(units), col=1)
    html.save(figure, title, output)
