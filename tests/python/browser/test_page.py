"""The page without a drive: several drives by id, pause, zoom, cursors, narrow pages, and a server that is gone."""

import re
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from background import Background
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from handling_page import reading, wait_for, wait_until_drawn
from page_client import DashboardProcess
from page_faults import pale, sideways
from playwright.sync_api import Page
from sextant_py import dds, plot, signal_file, telemetry_types
from sextant_py.contract import Contract

NEAR = 0.05


class RampWriter(Background):
    """Telemetry of one drive, 1 kHz, with a torque that rises by 1 N·m a second."""

    def __init__(self, domain: int, drive_id: int, begin_nm: float) -> None:
        kind = telemetry_types.struct("DriveTelemetry")
        self._node = dds.Node(domain)
        self._writer = DataWriter(
            self._node.participant, Topic(self._node.participant, dds.TELEMETRY, kind), dds.streaming_qos(1)
        )
        self._state = telemetry_types.DriveStateKind.TORQUE
        self._sample = lambda k: telemetry_types.sample(
            kind,
            drive_id=drive_id,
            sequence=k,
            t_ns=k * 1_000_000,
            torque_mean_nm=begin_nm + k * 1e-3,
            flux_mean_wb=1.0,
            state=self._state,
        )
        super().__init__()

    def _run(self) -> None:
        begin_s, k = time.monotonic(), 0
        while not self._stop.wait(0.005):
            while k < (time.monotonic() - begin_s) * 1e3:
                self._writer.write(self._sample(k))
                k += 1


@pytest.fixture
def two_drives(domain: int) -> Iterator[None]:
    with ExitStack() as stack:
        for drive_id, begin_nm in ((3, 100.0), (8, -100.0)):
            stack.enter_context(RampWriter(domain, drive_id, begin_nm))
        yield


@pytest.fixture
def watching(domain: int, tmp_path: Path) -> Iterator[DashboardProcess]:
    with DashboardProcess(domain, tmp_path) as process:
        yield process


def test_drives_by_id_pause_zoom_and_cursors(
    two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    page = open_page(watching.address)
    wait_for(lambda: len(page.query_selector_all('#drives [role="tab"]')) == 2, "two tabs", page)
    wait_for(lambda: reading(page, "torque_mean_nm") > 50, "the first drive", page)
    page.focus('#drives [aria-selected="true"]')
    page.keyboard.press("ArrowRight")
    wait_for(lambda: reading(page, "torque_mean_nm") < -50, "the other drive", page)
    assert page.inner_text('#drives [aria-selected="true"]') == "Drive 8"
    page.wait_for_timeout(1500)
    check_pause(page)
    check_zoom_and_cursors(page)


def estimate(page: Page) -> float:
    """The value beside the plot of the torque; NaN while there is none."""
    text = page.inner_text('[data-panel="torque"] .key:nth-of-type(2) output').replace("−", "-")
    return float(text or "nan")


def check_pause(page: Page) -> None:
    page.keyboard.press("p")
    wait_for(lambda: page.get_attribute("#pause", "aria-pressed") == "true", "the pause", page)
    wait_until_drawn(page)
    held = estimate(page)
    page.wait_for_timeout(500)
    assert estimate(page) == held
    assert reading(page, "torque_mean_nm") > held, "the readings go on"


def check_zoom_and_cursors(page: Page) -> None:
    page.select_option("#window", "1")
    wait_until_drawn(page)
    box = page.locator('[data-panel="torque"] .u-over').bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] * 0.5, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.75, middle, steps=4)
    page.mouse.up()
    page.wait_for_selector("#unzoom:not([disabled])")
    page.click("#cursors")
    wait_until_drawn(page)
    first, second = page.locator('#cursor-panel input[type="range"]').all()
    first.fill("-1")
    second.fill("0")
    wait_until_drawn(page)
    row = page.locator("#cursor-panel tbody tr").first.locator("td")
    wait_for(lambda: row.nth(2).inner_text() != "", "the times", page)
    times = [float(text.removesuffix(" s").replace("−", "-")) for text in row.all_inner_texts()[:3]]
    assert times == pytest.approx([-0.5, -0.25, 0.25], abs=0.02)
    torque = page.locator("#cursor-panel tbody tr", has_text="Torque, estimate").locator("td").all_inner_texts()
    assert float(torque[2]) == pytest.approx(times[2] * 1.0, abs=NEAR), "1 N·m a second"
    page.click("#unzoom")
    page.click("#pause")
    wait_for(lambda: page.get_attribute("#pause", "aria-pressed") == "false", "the live picture", page)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_narrow_page_needs_no_sideways_scrolling(
    scheme: str, two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    page = open_page(watching.address, width=400, color_scheme=scheme)
    wait_for(lambda: reading(page, "flux_mean_wb") > 0.5, "telemetry of either drive", page)
    page.click("#cursors")
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    assert page.evaluate("document.documentElement.dataset.theme") == scheme
    page.click("#theme")
    page.click("#theme")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.reload()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


# Parts of the tiles of the headline that reach out of their tile, where each reading is long.
OUT_OF_TILES = """() => {
  document.querySelectorAll("[data-reading]").forEach((one) => { one.textContent = "−12345.67"; });
  return [...document.querySelectorAll("#readings > div")].flatMap((tile) => [...tile.querySelectorAll("*")]
    .filter((one) => one.getBoundingClientRect().right > tile.getBoundingClientRect().right)
    .map((one) => one.textContent));
}"""


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_is_read_in_each_width_and_scheme(
    width: int, scheme: str, two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    page = open_page(watching.address, width=width, color_scheme=scheme)
    wait_for(lambda: reading(page, "flux_mean_wb") > 0.5, "telemetry of either drive", page)
    page.click("#cursors")
    assert sideways(page) == pale(page) == []


@pytest.mark.parametrize("width", [1280, 400])
def test_long_readings_stay_in_their_tiles(
    width: int, watching: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    page = open_page(watching.address, width=width)
    page.wait_for_selector("#readings small")
    assert page.evaluate(OUT_OF_TILES) == []


def test_events_are_listed_and_units_are_alike(
    two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page], domain: int
) -> None:
    node, kind = dds.Node(domain), telemetry_types.struct("DriveState")
    writer = DataWriter(node.participant, Topic(node.participant, dds.STATE, kind), dds.latched_qos())
    latched = 1 << Contract().faults()["OPEN_PHASE"]

    def write(sequence: int, state: str, latched: int = 0) -> None:
        found = telemetry_types.DriveStateKind[state]
        writer.write(
            telemetry_types.sample(
                kind, drive_id=3, sequence=sequence, t_ns=sequence * 1_000_000, state=found, faults_latched=latched,
                reason="phase <b>a</b> is open" if latched else "",
            )
        )  # fmt: skip

    page = open_page(watching.address)
    wait_for(lambda: page.inner_text("#events") == "none yet", "the empty list", page)
    write(1, "TORQUE")
    wait_for(lambda: "TORQUE" in page.inner_text("#events"), "the state", page)
    write(2, "FAULT", latched)
    wait_for(lambda: page.locator("#events li").count() == 2, "the fault", page)
    first = page.inner_text("#events li:first-child")
    assert re.fullmatch(r"\d\d:\d\d:\d\d\.\d{3} TORQUE → FAULT; OPEN_PHASE", first)
    assert page.get_attribute("#events li:first-child time", "title") == "0.002000 s on the drive's clock"
    names, units = (page.locator(f"#readings {part}").all_inner_texts() for part in ("dt", "small"))
    of_tiles = dict(zip(names, units, strict=True))
    for name, panel in (("Torque", "torque"), ("Speed", "speed"), ("Stator flux", "flux"), ("DC link", "u_dc")):
        assert page.inner_text(f'[data-panel="{panel}"] h2 small') == of_tiles[name]


def test_what_is_recorded_is_saved(
    two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page], tmp_path: Path
) -> None:
    page = open_page(watching.address)
    wait_for(lambda: reading(page, "torque_mean_nm") > 50, "the first drive", page)
    begin_nm = reading(page, "torque_mean_nm")
    page.click("#record")
    page.wait_for_timeout(1500)
    assert page.get_attribute("#record", "aria-pressed") == "true"
    with page.expect_download() as download:
        page.click("#record")
    assert re.fullmatch(r"drive_3_[-T0-9]+\.csv", download.value.suggested_filename)
    file = tmp_path / "recorded.csv"
    download.value.save_as(file)
    assert page.inner_text("#record") == "Record"
    signals = signal_file.load(file)
    assert len(signals.time_s) > 100
    assert np.all(np.diff(signals.values["sequence"]) > 0)
    torque = signals.values["torque_mean_nm"]
    assert begin_nm - 0.5 < torque[0] < torque[-1] < begin_nm + 30
    np.testing.assert_allclose(torque, 100 + 1e-3 * signals.values["sequence"], atol=1e-5)
    np.testing.assert_array_equal(signals.values["t_ns"], 1_000_000 * signals.values["sequence"])
    assert set(signals.values["state"]) == {4}
    assert plot.main([str(file), "-o", str(tmp_path / "page.html")]) == 0


def test_no_drive_is_explained(watching: DashboardProcess, open_page: Callable[..., Page], domain: int) -> None:
    page = open_page(watching.address)
    wait_for(lambda: "participant" in page.inner_text("#notices"), "the reason", page)
    assert f"No other DDS participant was discovered (domain {domain}, " in page.inner_text("#notices")
    assert page.inner_text("#link") == "no drive found"
    page.click("#scope-arm")
    wait_for(lambda: "no drive" in page.inner_text("#scope-say"), "the refusal of the scope", page)


def test_the_server_goes_and_returns(
    two_drives: None, watching: DashboardProcess, open_page: Callable[..., Page], domain: int, tmp_path: Path
) -> None:
    page = open_page(watching.address)
    wait_for(lambda: reading(page, "flux_mean_wb") > 0.5, "telemetry of either drive", page)
    wait_for(lambda: reading(page, "torque_mean_nm") > 50, "its torque", page)
    watching.send_signal(signal.SIGKILL)
    wait_for(lambda: "No connection to the dashboard's server" in page.inner_text("#notices"), "the sentence", page)
    assert reading(page, "torque_mean_nm") > 50, "the last picture stays"
    port = watching.address.rstrip("/").rpartition(":")[2]
    with DashboardProcess(domain, tmp_path, "--port", port):
        wait_for(lambda: page.inner_text("#link") == "live", "the connection", page)
        wait_for(lambda: reading(page, "flux_mean_wb") > 0.5, "telemetry of either drive", page)
        before = reading(page, "torque_mean_nm")
        wait_for(lambda: reading(page, "torque_mean_nm") > before, "telemetry again", page)
