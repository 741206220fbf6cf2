"""The processor time of the dashboard's server at 1 kHz telemetry with a page open: scripts/check_dashboard --load."""

import time
from collections.abc import Callable

import psutil
from drive_process import DriveProcess
from handling_page import wait_for, wait_for_state
from page_client import DashboardProcess
from playwright.sync_api import Page

SECONDS = 8.0
MOST_SHARE = 0.25  # of one core


def share(process: psutil.Process) -> float:
    def used_s() -> float:
        times = process.cpu_times()
        return times.user + times.system

    before_s, begin_s = used_s(), time.monotonic()
    time.sleep(SECONDS)
    return (used_s() - before_s) / (time.monotonic() - begin_s)


def test_load(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    start_drive()
    page = open_page(dashboard.address)
    wait_for_state(page, "STANDBY")
    page.click("#take")
    page.wait_for_selector("#enable:not([disabled])")
    server = psutil.Process(dashboard.pid)
    (vehicle,) = server.children()
    plain = share(server)
    print(f"server {plain:.1%} of one core; the process that commands {share(vehicle):.1%}")
    page.click("#scope-arm")
    wait_for(lambda: "waiting for: fault" in page.inner_text("#scope-say"), "the armed scope", page)
    print(f"server with the scope on {share(server):.1%}")
    assert plain < MOST_SHARE
