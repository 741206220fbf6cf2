"""Pictures of the page with a live drive: scripts/check_dashboard --screenshots DIRECTORY."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from handling_page import enable, set_torque, wait_for
from page_client import DashboardProcess
from playwright.sync_api import Page

DIRECTORY = Path(os.environ.get("SEXTANT_SCREENSHOTS", "out/dashboard"))
WIDTHS, SCHEMES = (1280, 400), ("light", "dark")


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_picture(
    width: int,
    scheme: str,
    start_drive: Callable[..., object],
    dashboard: DashboardProcess,
    open_page: Callable[..., Page],
) -> None:
    start_drive(load=())
    page = open_page(dashboard.address, width=width, color_scheme=scheme)
    enable(page)
    page.select_option("#window", "5")
    set_torque(page, 20.0)
    page.wait_for_timeout(1500)
    page.select_option("#trigger", "step SIZE")
    page.select_option("#scope select >> nth=-1", "normal")
    page.click("#scope-arm")
    wait_for(lambda: "waiting for: step" in page.inner_text("#scope-say"), "the armed scope", page)
    page.wait_for_timeout(200)
    set_torque(page, -15.0)
    page.wait_for_selector("#scope-download:not([hidden])")
    page.wait_for_timeout(1000)
    page.click("#plant-faults summary")
    page.click("#wrong-frames summary")
    DIRECTORY.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=DIRECTORY / f"dashboard_{width}_{scheme}.png", full_page=True)
    page.evaluate("scrollTo(0, 0)")
    page.screenshot(path=DIRECTORY / f"dashboard_{width}_{scheme}_top.png")
