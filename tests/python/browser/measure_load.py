"""The processor time of the dashboard's server, and how often the page draws: scripts/check_dashboard --load."""

import time
from collections.abc import Callable

import psutil
from drive_process import DriveProcess
from handling_page import wait_for, wait_for_state
from page_client import DashboardProcess
from playwright.sync_api import Page

SECONDS = 8.0
MOST_SHARE = 0.25  # of one core
LEAST_RATE_HZ = 25.0  # of drawing; a browser without a screen on the cores of the drive

# Every drawing of the page replaces the values beside the α–β plane.
COUNT_DRAWINGS = """seconds => new Promise(done => {
  let count = 0;
  new MutationObserver(() => { count += 1; }).observe(document.getElementById("plane-values"), {childList: true});
  setTimeout(() => done(count / seconds), seconds * 1000);
})"""


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
    rate_hz = page.evaluate(COUNT_DRAWINGS, SECONDS)
    print(f"the page draws {rate_hz:.1f} times a second")
    print(f"server {plain:.1%} of one core; the process that commands {share(vehicle):.1%}")
    page.click("#scope-arm")
    wait_for(lambda: "waiting for: fault" in page.inner_text("#scope-say"), "the armed scope", page)
    print(f"server with the scope on {share(server):.1%}")
    assert plain < MOST_SHARE
    assert rate_hz > LEAST_RATE_HZ
