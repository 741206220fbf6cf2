"""The page of scripts/report in a browser: it fits 1280 and 400 pixels, light and dark, and loads nothing."""

from collections.abc import Callable
from pathlib import Path

import made_recording
import pytest
from playwright.sync_api import Page
from sextant_py import report
from test_report import directory, live


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits(width: int, scheme: str, tmp_path: Path, open_page: Callable[..., Page]) -> None:
    made_recording.write(live(), tmp_path / "live.h5")
    out = tmp_path / "report.html"
    assert report.main([str(directory(tmp_path / "run")), str(tmp_path / "live.h5"), "--out", str(out)]) == 0
    page = open_page(out.as_uri(), width=width, color_scheme=scheme, offline=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate("[...document.querySelectorAll('.scroll')].every(e => e.scrollWidth <= e.clientWidth + 1)")
    loaded = "[...document.images].every(image => image.complete && image.naturalWidth > 0)"
    assert page.evaluate(f"document.images.length > 0 && {loaded}")
    chosen = page.evaluate("document.images[0].currentSrc")
    plain = page.evaluate("document.images[0].src")
    assert (chosen == plain) == (width == 1280 and scheme == "light")
    background = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert background == {"light": "rgb(243, 245, 248)", "dark": "rgb(15, 20, 27)"}[scheme]
    page.emulate_media(media="print")
    page.wait_for_function("document.images[0].currentSrc == document.images[0].src")
