"""The page of scripts/report in a browser: it fits 1280 and 400 pixels, light and dark, and loads nothing."""

import json
from collections.abc import Callable
from pathlib import Path

import made_recording
import pytest
from matplotlib.figure import Figure
from page_faults import pale, sideways
from playwright.sync_api import Page
from sextant_py import nameplate, report
from test_report import directory, live

PLATE = "--power-w 2200 --voltage-v 400 --current-a 5 --speed-rpm 1430 --frequency-hz 50 --power-factor 0.79"


def sweep(path: Path) -> Path:
    """What scripts/sweep leaves: a picture has the width that its columns need."""
    path.mkdir()
    (path / "sweep.json").write_text(json.dumps({"name": "bands", "points": 1, "scenario": "x.toml"}))
    (path / "points.jsonl").write_text(json.dumps({"point": 0, "status": "ok", "reason": "", "metrics": {}}) + "\n")
    Figure(figsize=(7.5, 5.2)).savefig(path / "torque_bias_nm.png", dpi=150)
    return path


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_sweep_and_a_name_plate_fit(width: int, scheme: str, tmp_path: Path, open_page: Callable[..., Page]) -> None:
    assert report.main([str(sweep(tmp_path / "sweep")), "--out", str(tmp_path / "sweep.html")]) == 0
    assert nameplate.main([*PLATE.split(), "--connection", "star", "--out", str(tmp_path / "plate")]) == 0
    for file in (tmp_path / "sweep.html", tmp_path / "plate" / "report.html"):
        page = open_page(file.as_uri(), width=width, color_scheme=scheme)
        assert sideways(page) == pale(page) == []
        pictures = "[...document.querySelectorAll('figure > *')]"
        assert page.evaluate(f"{pictures}.every(one => one.scrollWidth <= one.parentElement.clientWidth)")


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits(width: int, scheme: str, tmp_path: Path, open_page: Callable[..., Page]) -> None:
    made_recording.write(live(), tmp_path / "live.h5")
    out = tmp_path / "report.html"
    assert report.main([str(directory(tmp_path / "run")), str(tmp_path / "live.h5"), "--out", str(out)]) == 0
    page = open_page(out.as_uri(), width=width, color_scheme=scheme, offline=True)
    assert sideways(page) == pale(page) == []
    loaded = "[...document.images].every(image => image.complete && image.naturalWidth > 0)"
    assert page.evaluate(f"document.images.length > 0 && {loaded}")
    chosen = page.evaluate("document.images[0].currentSrc")
    plain = page.evaluate("document.images[0].src")
    assert (chosen == plain) == (width == 1280 and scheme == "light")
    background = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert background == {"light": "rgb(243, 245, 248)", "dark": "rgb(15, 20, 27)"}[scheme]
    page.emulate_media(media="print")
    page.wait_for_function("document.images[0].currentSrc == document.images[0].src")
