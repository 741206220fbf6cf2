"""Fixtures of the tests of the dashboard's page: Chromium without a screen, sextant-ecu as a process."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from drive_process import WIDE, DriveProcess
from page_client import TOKEN, DashboardProcess
from playwright.sync_api import Browser, Page, sync_playwright

PATIENCE_MS = 60_000  # a wait ends as soon as what it waits for is there
WIDTH, HEIGHT = 1280, 900
LOAD = ("load.kind=imposed_speed", "load.speed_rad_s.value=10")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    program = shutil.which("chromium")
    if program is None:
        pytest.fail("chromium is missing; scripts/setup --gates installs it.")
    with sync_playwright() as playwright:
        # As root Chromium starts without its sandbox alone; it opens nothing but the page of the test.
        found = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Callable[..., Page]]:
    """open_page(address, width=…): the page, which must not report an error of its script."""
    contexts, errors = [], []

    def opened(address: str, **options: object) -> Page:
        size = {"width": int(options.pop("width", WIDTH)), "height": HEIGHT}
        context = browser.new_context(viewport=size, **options)
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert errors == []


def fault_socket(folder: Path) -> Path:
    """Of the drive of a test, whose plant takes faults."""
    return folder / "faults"


@pytest.fixture
def start_drive(domain: int, bus_address: str, tmp_path: Path) -> Iterator[Callable[..., DriveProcess]]:
    """start_drive(key=value…): a running sextant-ecu whose timeouts no machine that stands still reaches."""
    with ExitStack() as stack:

        def start(*settings: str, load: tuple[str, ...] = LOAD) -> DriveProcess:
            words = ("--fault-socket", fault_socket(tmp_path))
            return stack.enter_context(DriveProcess(bus_address, domain, tmp_path, (*WIDE, *load, *settings), words))

        yield start


@pytest.fixture
def dashboard(domain: int, bus_address: str, tmp_path: Path) -> Iterator[DashboardProcess]:
    """A dashboard whose pages may command with TOKEN, and keep the command on a machine that stands still."""
    arguments = ("--allow-command", "--can", bus_address, "--token", TOKEN, "--demand-timeout", "30")
    with DashboardProcess(domain, tmp_path, *arguments, "--fault-socket", fault_socket(tmp_path)) as process:
        yield process
