"""The page with a live drive: torque, faults, captures, and the end of the commands with the page."""

import signal
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from drive_process import DriveProcess
from handling_page import enable, reading, set_torque, wait_for, wait_for_state, wait_for_torque
from page_client import DashboardProcess
from playwright.sync_api import Page
from repeating_vehicle import RepeatingVehicle
from sextant_py.telemetry_contract import enumerators
from telemetry_record import Span, TelemetryRecord

TORQUE_NM = 10.0
WITHIN_NM = 1.0
FAULT = enumerators("DriveStateKind").index("FAULT")
CONTRACT_NS = 60_000_000  # docs/can.md: timeout_ms, zero_ramp_ms, and the drive's wake-ups
PERIOD_NS = 1_000_000  # of telemetry


def brought_up(page: Page, vehicle: RepeatingVehicle) -> None:
    vehicle.demand()
    wait_for_state(page, "READY")
    vehicle.demand(0.0, enable=True)
    wait_for_state(page, "TORQUE")


def test_torque_commanded_over_can_is_shown(
    start_drive: Callable[..., DriveProcess],
    dashboard: DashboardProcess,
    open_page: Callable[..., Page],
    bus_address: str,
) -> None:
    start_drive()
    page = open_page(dashboard.address)
    with RepeatingVehicle(bus_address) as vehicle:
        brought_up(page, vehicle)
        wait_for_torque(page, 0.0, WITHIN_NM)
        vehicle.demand(TORQUE_NM, enable=True)
        took_s = wait_for_torque(page, TORQUE_NM, WITHIN_NM)
        print(f"{TORQUE_NM:g} N·m was shown {took_s:.2f} s after the demand")
        wait_for(
            lambda: reading(page, "torque_requested_nm") == pytest.approx(TORQUE_NM, abs=0.01), "the request", page
        )
        assert page.inner_text("#state-name") == "TORQUE"
        assert page.inner_text("#link") == "live"
        vehicle.demand(-TORQUE_NM, enable=True)
        wait_for_torque(page, -TORQUE_NM, WITHIN_NM)


def test_a_fault_is_red_and_its_capture_shows_the_periods_before_it(
    start_drive: Callable[..., DriveProcess],
    dashboard: DashboardProcess,
    open_page: Callable[..., Page],
    bus_address: str,
    tmp_path: Path,
) -> None:
    start_drive("command.timeout_ms=1000", "command.lost_ms=2000")
    page = open_page(dashboard.address)
    with RepeatingVehicle(bus_address) as vehicle:
        brought_up(page, vehicle)
        green = page.evaluate("getComputedStyle(document.getElementById('state')).backgroundColor")
        page.click("#scope-arm")
        wait_for(lambda: "waiting for: fault" in page.inner_text("#scope-say"), "the armed scope", page)
        page.wait_for_timeout(200)  # periods before the trigger
        vehicle.stop_sending()
        wait_for_state(page, "FAULT")
    red = page.evaluate("getComputedStyle(document.getElementById('state')).backgroundColor")
    assert (green, red) == ("rgb(26, 127, 75)", "rgb(196, 32, 43)")
    assert page.inner_text("#state-name") == "FAULT"
    wait_for(lambda: "COMMAND_LOST" in page.inner_text("#faults"), "the fault's name", page)
    assert "latched" in page.inner_text("#faults") or "present" in page.inner_text("#faults")
    with page.expect_download() as download:
        page.click("#scope-download")
    file = tmp_path / "capture.h5"
    download.value.save_as(file)
    check_capture(file, page.inner_text("#scope-caption"))


def check_capture(path: Path, caption: str) -> None:
    """20 ms before the fault and 50 ms after it, less what a machine that stood still left out."""
    with h5py.File(path) as file:
        rows = {name: np.asarray(values) for name, values in file["waveform"].items()}
    first = int(np.flatnonzero(rows["state"] == FAULT)[0])
    times_ms = (rows["t_ns"].astype(np.int64) - int(rows["t_ns"][first])) * 1e-6
    assert first >= 100, "control periods before the fault"
    assert set(rows["state"][:first]).isdisjoint({FAULT})
    assert times_ms[0] >= -20.05
    assert times_ms[-1] <= 50.05
    begin, end = (f"{time_ms:.1f}".replace("-", "−") for time_ms in (times_ms[0], times_ms[-1]))
    assert "".join(caption.split()).startswith(f"Capture1:fault,{begin}…{end}ms,")
    assert f"{len(times_ms)}controlperiods" in "".join(caption.split())


def test_the_drive_ends_and_returns(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    drive = start_drive()
    page = open_page(dashboard.address)
    wait_for_state(page, "STANDBY")
    wait_for(lambda: reading(page, "u_dc_v") > 100.0, "the DC link", page)
    link_v = reading(page, "u_dc_v")
    drive.leave(signal.SIGKILL)
    wait_for(lambda: "no telemetry for" in page.inner_text("#notices"), "the sentence", page)
    assert "Drive 1: no telemetry for" in page.inner_text("#notices")
    assert page.inner_text("#state-name") == "STANDBY (last received)"
    assert reading(page, "u_dc_v") == link_v
    wait_for(lambda: "drive 1: no telemetry; " in dashboard.text(), "the sentence in the terminal", page)
    start_drive()
    wait_for(lambda: page.inner_text("#notices") == "", "the drive's return", page)
    wait_for(lambda: page.inner_text("#state-name") == "STANDBY", "the state", page)


def test_closing_the_page_brings_zero_torque(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page], domain: int
) -> None:
    """Within the time of the contract, on the drive's clock; time in which the drive stood still does not count."""
    start_drive("command.timeout_ms=40")
    record = TelemetryRecord(domain)
    page = open_page(dashboard.address)
    enable(page)
    set_torque(page, TORQUE_NM)
    wait_for_torque(page, TORQUE_NM, WITHIN_NM)
    record.wait(lambda own: own.samples and own.samples[-1].torque_reference_nm > TORQUE_NM - 0.1, "the reference")
    closed_s = time.monotonic()
    page.close()
    record.wait(lambda own: settled_at_zero(own.samples), "zero torque")
    print(f"zero torque was received {time.monotonic() - closed_s:.2f} s after the page was closed")
    span = Span(record.samples)
    ended = np.flatnonzero(span.torque_reference_nm > 0)[-1] + 1
    took_ns = span.t_ns[ended] - span.command_received_ns[ended]
    since = span.t_ns >= span.command_received_ns[ended]
    stood_still_ns = int(np.sum(np.maximum(np.diff(span.t_ns[since]) - PERIOD_NS, 0)))
    print(f"the reference was zero {took_ns / 1e6:.1f} ms after the last command")
    assert took_ns <= CONTRACT_NS + stood_still_ns
    assert abs(span.torque_mean_nm[-1]) < WITHIN_NM


def settled_at_zero(samples: list) -> bool:
    newest = samples[-100:]
    commanded = len({sample.command_received_ns for sample in newest}) > 1
    return len(newest) == 100 and not commanded and all(sample.torque_reference_nm == 0 for sample in newest)


def test_without_the_token_no_command_is_accepted(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page], domain: int
) -> None:
    start_drive()
    record = TelemetryRecord(domain)
    address = dashboard.address.partition("#")[0]
    page = open_page(address)
    wait_for(lambda: "no token" in page.inner_text("#command"), "the sentence", page)
    assert page.is_disabled("#take")
    refused = page.evaluate(
        """address => new Promise(done => {
             const socket = new WebSocket(address), found = [];
             socket.onopen = () => {
               socket.send(JSON.stringify({type: "take", token: "a guess"}));
               socket.send(JSON.stringify({type: "demand", torque_nm: 10, enable: true, fault_reset: false}));
             };
             socket.onmessage = ({data}) => {
               const message = typeof data === "string" ? JSON.parse(data) : {};
               if (message.type === "refused" && found.push(message.text) === 2) done(found);
             };
           })""",
        dashboard.socket,
    )
    assert "token" in refused[0]
    assert "does not command" in refused[1]
    received, _ = record.counted_commands()
    assert received == 0
    wrong = open_page(address + "#token=wrong-token")
    wrong.click("#take")
    wait_for(lambda: "token" in wrong.inner_text("#command .say"), "the refusal", wrong)
    assert record.counted_commands()[0] == 0


def test_a_fault_from_the_page_trips_the_drive_and_the_page_takes_it_back(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    start_drive()
    page = open_page(dashboard.address)
    page.wait_for_selector("#take:not([disabled])")
    assert page.is_hidden("#plant-faults")
    enable(page)
    set_torque(page, TORQUE_NM)
    wait_for_torque(page, TORQUE_NM, WITHIN_NM)
    page.click("#plant-faults summary")
    page.fill('#plant-faults label:has-text("jump_rad_s") input', "100")
    page.click('#plant-faults [data-kind="speed_jump"]')
    wait_for_state(page, "FAULT")
    assert page.inner_text("#plant-faults .say") == "The plant has: speed jump."
    page.fill('#plant-faults label:has-text("at_s") input', "-1")
    page.click('#plant-faults [data-kind="open_phase"]')
    wait_for(lambda: "plant.faults.at_s" in page.inner_text("#plant-faults .say"), "the refusal", page)
    page.click('#plant-faults [data-kind="none"]')
    wait_for(lambda: page.inner_text("#plant-faults .say") == "No fault from now on.", "the end of the fault", page)
    page.click("#reset:not([disabled])")
    page.click("#enable:not([disabled])")
    wait_for_state(page, "TORQUE")
    page.click("#release")
    wait_for(lambda: page.is_hidden("#plant-faults"), "no faults from a page that does not command", page)


def test_wrong_frames_from_the_page_trip_the_drive(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    start_drive()
    page = open_page(dashboard.address)
    page.wait_for_selector("#take:not([disabled])")
    assert page.is_hidden("#wrong-frames")
    enable(page)
    page.click("#wrong-frames summary")
    page.fill("#wrong-frames input", "10")
    page.click('#wrong-frames [data-wrong="crc"]')
    wait_for_state(page, "FAULT")
    wait_for(lambda: "COMMAND_INVALID" in page.inner_text("#faults"), "the fault's name", page)


def test_a_second_page_sees_who_commands(
    start_drive: Callable[..., DriveProcess], dashboard: DashboardProcess, open_page: Callable[..., Page]
) -> None:
    start_drive()
    first = open_page(dashboard.address)
    enable(first)
    second = open_page(dashboard.address)
    wait_for(lambda: "commands" in second.inner_text("#command .say"), "who commands", second)
    assert "page 1 (127.0.0.1) commands" in second.inner_text("#command .say")
    assert second.is_disabled("#take")
    first.keyboard.press("Escape")
    wait_for_state(first, "READY")
    first.click("#release")
    second.click("#take:not([disabled])")
    second.wait_for_selector("#enable:not([disabled])")
