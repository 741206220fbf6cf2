"""What a person does on the page, and reads from it."""

import time
from collections.abc import Callable

from playwright.sync_api import Page

PATIENCE_S = 60.0


def reading(page: Page, name: str) -> float:
    """A reading of the headline; NaN while there is none."""
    text = page.inner_text(f'[data-reading="{name}"]').replace("−", "-")
    return float("nan") if text in ("", "–") else float(text)


def wait_until_drawn(page: Page) -> None:
    """Until the page has drawn what was asked of it: it draws at most every 33 ms."""
    page.evaluate("""() => new Promise(done => setTimeout(
        () => requestAnimationFrame(() => requestAnimationFrame(done)), 100))""")


def wait_for(condition: Callable[[], bool], what: str, page: Page) -> float:
    """Waits; how long it took [s]."""
    begin_s = time.monotonic()
    while not condition():
        waited_s = time.monotonic() - begin_s
        assert waited_s < PATIENCE_S, (
            f"waited {waited_s:.0f} s for {what}; the page shows {page.inner_text('body')[:600]}"
        )
        page.wait_for_timeout(20)
    return time.monotonic() - begin_s


def wait_for_torque(page: Page, torque_nm: float, within_nm: float) -> float:
    return wait_for(
        lambda: abs(reading(page, "torque_mean_nm") - torque_nm) < within_nm, f"{torque_nm:g} N·m on the page", page
    )


def wait_for_state(page: Page, state: str) -> float:
    return wait_for(lambda: page.get_attribute("#state", "data-state") == state, f"the state {state}", page)


def enable(page: Page) -> None:
    """Takes control and enables the drive, without torque."""
    page.click("#take")
    page.click("#enable:not([disabled])")
    wait_for_state(page, "TORQUE")


def set_torque(page: Page, torque_nm: float) -> None:
    page.fill("#torque", f"{torque_nm:g}")
    page.press("#torque", "Enter")
