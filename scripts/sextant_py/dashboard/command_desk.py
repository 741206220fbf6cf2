"""Who commands: one page at a time, with the token, as long as it renews its demand."""

from typing import Any, Protocol

from ..finite import is_finite
from ..wrong_frames import WRONG
from .access import Access
from .vehicle import Vehicle

MOST_WRONG_FRAMES = 100
WRONG_TOKEN = "the token is not the one that the dashboard printed; open the page by the address it printed."


class RefusedError(Exception):
    """Why a command is not accepted, in one sentence."""


class Page(Protocol):
    """A connected page, with the name that others are shown."""

    name: str


class CommandDesk:
    """Checks each command that comes from a page and hands it to the vehicle."""

    def __init__(self, access: Access, vehicle: Vehicle | None, takes_faults: bool = False) -> None:
        """takes_faults: the page that commands may also give the plant faults."""
        self._takes_faults = takes_faults
        self._access = access
        self._vehicle = vehicle
        self._holder: Page | None = None
        self._session = 0  # counts the pages that took command: a late report of the one before changes nothing
        self._report: dict[str, Any] = {}
        self.has_ended = False

    def take(self, page: Page, token: object) -> None:
        """Makes the page the one that commands."""
        if self._vehicle is None:
            raise RefusedError("this dashboard does not command; it was started without --allow-command.")
        if not self._access.may_command(token):
            raise RefusedError(WRONG_TOKEN)
        if self.has_ended:
            raise RefusedError("the process that commands has ended; restart the dashboard.")
        if self._holder not in (None, page):
            raise RefusedError(f"{self._holder.name} commands; it has to release the drive first.")
        if self._holder is None:
            self._session += 1
        self._holder = page
        self._order(torque_nm=0.0, enable=False, fault_reset=False)  # from now on demands have to be renewed

    def demand(self, page: Page, message: dict[str, Any]) -> None:
        self.check_holder(page)
        torque, enable, reset = (message.get(name) for name in ("torque_nm", "enable", "fault_reset"))
        if isinstance(torque, bool) or not isinstance(torque, (int, float)) or not is_finite(torque):
            raise RefusedError("torque_nm must be a number.")
        if not isinstance(enable, bool) or not isinstance(reset, bool):
            raise RefusedError("enable and fault_reset must be true or false.")
        limit = self._vehicle.torque_limit_nm
        if abs(torque) > limit:
            raise RefusedError(f"the torque {torque:g} N·m is beyond ±{limit:g} N·m, which --torque-limit sets.")
        limit = self.torque_limit_nm
        self._order(torque_nm=min(max(float(torque), -limit), limit), enable=enable, fault_reset=reset)

    def spoil(self, page: Page, message: dict[str, Any]) -> None:
        """The next frames are wrong, in one of the ways of `sextant.Vcu`."""
        self.check_holder(page)
        kind, frames = message.get("kind"), message.get("frames")
        if not isinstance(kind, str) or kind not in WRONG:
            raise RefusedError(f"kind must be one of {', '.join(WRONG)}.")
        if isinstance(frames, bool) or not isinstance(frames, int) or not 1 <= frames <= MOST_WRONG_FRAMES:
            raise RefusedError(f"frames must be a whole number from 1 to {MOST_WRONG_FRAMES}.")
        self._order(spoil=kind, frames=frames)

    @property
    def torque_limit_nm(self) -> float:
        """Largest torque that is sent: within --torque-limit the larger of the torques that the running drive reports
        as available for motoring and regenerating, which its own limit bounds; 0 while it reports none. [N·m]

        The larger one, since which of them holds depends on the direction of rotation: a request beyond the smaller one
        is derated by the drive, one beyond its limit would be a fault.
        """
        reported = (self._report.get(name) for name in ("motoring_nm", "regenerating_nm"))
        return min(self._vehicle.torque_limit_nm, max((nm for nm in reported if nm is not None), default=0.0))

    def release(self, page: Page) -> None:
        """Disable frames, then none."""
        self.check_holder(page)
        self._holder = None
        self._order(release=True)

    def leave(self, page: Page) -> None:
        """The page is gone: no further frame."""
        if page is self._holder:
            self._holder = None
            self._vehicle.order(session=self._session, stop=True)

    def _order(self, **order: object) -> None:
        if not self._vehicle.order(session=self._session, **order):
            self._holder, self.has_ended = None, True
            raise RefusedError("the process that commands has ended; restart the dashboard.")

    def check_holder(self, page: Page) -> None:
        """Refuses what a page asks that does not command."""
        if page is not self._holder:
            raise RefusedError("this page does not command; take control first.")

    def take_report(self, report: dict[str, Any] | None) -> None:
        """A report of the process. One that has stopped sending by itself has lost its page."""
        if report is None:
            self._holder, self.has_ended = None, True
            return
        was_sending = self._report.get("is_sending", False)
        if was_sending and not report["is_sending"] and report["session"] == self._session:
            self._holder = None
        self._report = report

    def described(self, page: Page | None) -> dict[str, Any]:
        """How commanding stands, for this page; without one, for pages that do not command."""
        if self._vehicle is None:
            return {"type": "command", "allowed": False}
        return {
            "type": "command",
            "allowed": True,
            "has_ended": self.has_ended,
            "bus": self._vehicle.address,
            "torque_limit_nm": self.torque_limit_nm,
            "holder": self._holder.name if self._holder else None,
            "is_mine": page is not None and page is self._holder,
            "takes_faults": self._takes_faults,
            "wrong_frames": {kind: wrong.meaning for kind, wrong in WRONG.items()},
            **self._report,
        }
