"""Pictures by their committed results: texts that stand clear of each other and inside, panels that belong together."""

import itertools
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from sextant_py import identify_picture
from sextant_py.identify_inertia import Inertia
from studies import json_file
from studies.bench import plots as bench
from studies.bench.histogram import Histogram
from studies.controllers import compare_controllers
from studies.controllers import figures as controllers
from studies.machine_library import figure, machine_library
from studies.machine_library import results as machines
from studies.motulator import compare_motulator
from studies.motulator import figures as motulator
from studies.work_precision import work_precision

NEAR = 1.0  # pixels by which boxes of texts may be in each other


def laid_out(figure: Figure) -> FigureCanvasAgg:
    """A figure that is closed has no canvas that draws."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas


def boxes(figure: Figure) -> list[tuple[str, Bbox]]:
    """The texts that are drawn, in pixels; an oblique one has no box of its own."""
    found, draw = [], Text.draw

    def recorded(text: Text, renderer: object) -> None:
        if text.get_text().strip() and text.get_visible() and text.get_rotation() % 90 == 0:
            found.append((text.get_text(), text.get_window_extent(renderer)))
        draw(text, renderer)

    with pytest.MonkeyPatch.context() as patched:
        canvas = laid_out(figure)
        patched.setattr(Text, "draw", recorded)
        canvas.draw()
    return found


def collisions(figure: Figure) -> list[tuple[str, str]]:
    def are_one(one: Bbox, other: Bbox) -> bool:
        both = Bbox.intersection(one, other)
        return both is not None and both.width > NEAR and both.height > NEAR

    pairs = itertools.combinations(boxes(figure), 2)
    return [(one, other) for (one, box), (other, further) in pairs if are_one(box, further)]


def outside(figure: Figure) -> list[str]:
    whole = figure.bbox.padded(NEAR)
    return [text for text, box in boxes(figure) if not (whole.contains(*box.min) and whole.contains(*box.max))]


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that are written, as they are then."""
    found = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: found.append(figure))
    return found


def draw_library(file: Path) -> None:
    figure.draw(json_file.read(machine_library.RESULTS, machines.Results, "machine_library"), file)


def draw_controllers(file: Path) -> None:
    results = json_file.read(compare_controllers.RESULTS, compare_controllers.Results, "compare_controllers")
    controllers.draw(results, file.parent)


def draw_motulator(file: Path) -> None:
    results = json_file.read(compare_motulator.RESULTS, compare_motulator.Results, "compare_motulator")
    motulator.draw(results, file)


def draw_precision(file: Path) -> None:
    work_precision.draw(work_precision.load(work_precision.DATA), file)


@pytest.mark.parametrize("draw", [draw_controllers, draw_library, draw_motulator, draw_precision])
def test_texts_stand_clear_of_each_other(draw: Callable[[Path], None], drawn: list[Figure], tmp_path: Path) -> None:
    draw(tmp_path / "picture.png")
    assert drawn
    assert [pair for figure in drawn for pair in collisions(figure)] == []
    assert [text for figure in drawn for text in outside(figure)] == []


def inside_circle(figure: Figure) -> list[str]:
    """Names of a radar's axes that stand on its outline."""
    laid_out(figure)
    found = []
    for axes in (axes for axes in figure.axes if axes.get_visible()):
        (x, y), (rim, _) = axes.transData.transform([(0, 0), (0, 1)])
        for label in axes.get_xticklabels():
            box = label.get_window_extent()
            nearest = np.clip(x, box.x0, box.x1) - x, np.clip(y, box.y0, box.y1) - y
            found += [label.get_text()] if np.hypot(*nearest) < rim - x else []
    return found


def test_the_names_of_a_radar_stand_outside_of_it(drawn: list[Figure], tmp_path: Path) -> None:
    draw_controllers(tmp_path / "picture.png")
    assert inside_circle(drawn[0]) == []


def test_an_axis_of_less_than_three_decades_has_more_ticks_than_their_ends(drawn: list[Figure]) -> None:
    wide = Histogram.of([10**exponent for exponent in range(9)])
    narrow = Histogram.of([40_000, 120_000, 700_000])
    bench.draw_latency({"wake-up": wide}, {"command": narrow}, Path())
    ticks = []
    for axes in drawn[0].axes:
        left, right = axes.get_xlim()
        ticks.append([tick for tick in axes.get_xticks() if left <= tick <= right])
    assert ticks[0] == pytest.approx([10.0**exponent for exponent in range(-3, 6)])
    assert ticks[1] == pytest.approx([50, 100, 200, 500])


def test_the_residual_of_identify_stands_below_what_it_is_of(drawn: list[Figure], tmp_path: Path) -> None:
    time_s = np.linspace(3, 5, 200)
    speed = 30 * np.sin(time_s)
    found = Inertia(0.5, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, time_s, speed, 0.99 * speed, 0 * speed)
    results = SimpleNamespace(found=None, impedance=None, fluxes=None, inertia=found)
    identify_picture.write_picture(tmp_path, results)
    above, below = drawn[0].axes
    below.set_xlim(0, 1)
    assert above.get_xlim() == (0, 1)
    laid_out(drawn[0])
    label, panel = below.yaxis.label.get_window_extent(), below.get_window_extent()
    assert panel.y0 - NEAR < label.y0 < label.y1 < panel.y1 + NEAR
