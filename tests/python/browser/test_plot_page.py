"""Pages of scripts/plot in Chromium: what fits a screen of 1280 and of 400 pixels, light and dark."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from page_faults import pale, sideways
from playwright.sync_api import Page
from sextant_py import plot

# Top and bottom of each panel and of its legend, in pixels of the page.
PLACES = """() => {
  const div = document.querySelector(".plotly-graph-div"), layout = div.layout;
  const frame = div.getBoundingClientRect(), { t, b } = layout.margin;
  const inner = layout.height - t - b;
  return layout.meta.panels.map((panel) => {
    const [low, high] = layout[panel.axis].domain;
    const legend = div.querySelector(`g.${panel.legend}`)?.getBoundingClientRect();
    return {
      top: frame.top + t + (1 - high) * inner, bottom: frame.top + t + (1 - low) * inner,
      legend: legend ? [legend.top, legend.bottom, legend.left, legend.right] : null,
    };
  });
}"""


def write_trace(path: Path) -> None:
    t_s = np.linspace(0, 1, 2000)
    with h5py.File(path, "w") as file:
        file["t_ns"] = (t_s * 1e9).astype(np.int64)
        for name, unit in (
            *((f"torque_{part}_nm", "N·m") for part in ("requested", "reference", "mean", "min", "max")),
            *((f"i_{phase}_a", "A") for phase in "abc"),
            ("speed_rad_s", "rad/s"),
        ):
            file[name] = np.sin(20 * t_s + len(name))
            file[name].attrs["unit"] = unit
        file["state"] = np.repeat(np.array([3, 4, 6], np.uint8), (200, 1000, 800))
        file["sector"] = 1 + np.arange(2000) // 50 % 6


@pytest.fixture
def page_file(tmp_path: Path) -> Path:
    files = [tmp_path / name / "trace.h5" for name in ("first", "second")]
    for file in files:
        file.parent.mkdir()
        write_trace(file)
    assert plot.main([*map(str, files), "-o", str(tmp_path / "page.html")]) == 0
    return tmp_path / "page.html"


def opened(open_page: Callable[..., Page], file: Path, **options: object) -> Page:
    page = open_page(file.as_uri(), **options)
    page.wait_for_function("document.querySelector('.plotly-graph-div')?.layout?.margin?.t === 8")
    return page


# The lines and spans of marks, the legends and the headings, in pixels: left, top, right, bottom.
BOXES = """() => {
  const box = (one) => ["left", "top", "right", "bottom"].map((side) => one.getBoundingClientRect()[side]);
  const headings = document.querySelector(".plotly-graph-div").layout.annotations.slice(0, 4).map((one) => one.text);
  const texts = [...document.querySelectorAll(".annotation-text")].filter((one) => headings.includes(one.textContent));
  return {
    marks: [...document.querySelectorAll(".shapelayer path")].map(box),
    texts: [...document.querySelectorAll("g.legend, g[class^=legend] .legendtext"), ...texts].map(box),
  };
}"""


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_marks_stand_in_the_panels_alone(
    open_page: Callable[..., Page], page_file: Path, width: int, scheme: str
) -> None:
    page = opened(open_page, page_file, width=width, color_scheme=scheme)
    boxes = page.evaluate(BOXES)
    assert len(boxes["marks"]) == 2 * 4 * 3, "of each file magnetising and its span, and a fault, in four panels"
    assert len(boxes["texts"]) > 8
    for left, top, right, bottom in boxes["marks"]:
        for from_x, from_y, to_x, to_y in boxes["texts"]:
            assert right < from_x or left > to_x or bottom < from_y or top > to_y
    assert sideways(page) == pale(page) == []


@pytest.mark.parametrize("width", [1280, 400])
def test_legends_stand_between_heading_and_panel(open_page: Callable[..., Page], page_file: Path, width: int) -> None:
    page = opened(open_page, page_file, width=width)
    assert page.title() == "first and second"
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    places = page.evaluate(PLACES)
    assert len(places) == 4
    for number, place in enumerate(places):
        top, bottom, left, right = place["legend"]
        assert bottom <= place["top"] + 1
        assert place["bottom"] - place["top"] > 60
        assert 0 <= left < right <= width
        if number:
            assert top > places[number - 1]["bottom"]


def test_a_page_has_the_colours_of_the_system(open_page: Callable[..., Page], page_file: Path) -> None:
    shown = "document.querySelector('.plotly-graph-div').layout.paper_bgcolor"
    back = "getComputedStyle(document.body).backgroundColor"
    page = opened(open_page, page_file, color_scheme="dark")
    assert (page.evaluate(shown), page.evaluate(back)) == ("#14181d", "rgb(20, 24, 29)")
    page.emulate_media(color_scheme="light")
    page.wait_for_function(f"{shown} === '#ffffff'")
    assert page.evaluate(back) == "rgb(255, 255, 255)"


def test_a_page_follows_the_width_of_its_window(open_page: Callable[..., Page], page_file: Path) -> None:
    page = opened(open_page, page_file, width=1280)
    page.set_viewport_size({"width": 400, "height": 900})
    page.wait_for_function("document.documentElement.scrollWidth <= 400")
    names = """document.querySelector('.plotly-graph-div').data.filter((trace) => trace.meta && trace.visible)
      .map((trace) => trace.meta)"""
    page.wait_for_function(f"new Set({names}).size === 1 && {names}[0] === 'narrow'")
