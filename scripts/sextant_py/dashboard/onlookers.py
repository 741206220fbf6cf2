"""What stands in the place of the desk where pages have no token: nothing that they send reaches the vehicle."""

from typing import Any

from .command_desk import Page, RefusedError


class Onlookers:
    """Shows who commands, and refuses every command."""

    def __init__(self, standing: dict[str, Any]) -> None:
        """standing: what the desk says of commanding, for any page."""
        self.standing = standing

    def take(self, _page: Page, _token: object) -> None:
        if not self.standing["allowed"]:
            raise RefusedError("this dashboard does not command; it was started without --allow-command.")
        raise RefusedError(
            "the token is not the one that the dashboard printed; open the page by the address it printed."
        )

    def check_holder(self, _page: Page) -> None:
        raise RefusedError("this page does not command; take control first.")

    def demand(self, page: Page, _message: dict[str, Any]) -> None:
        self.check_holder(page)

    def release(self, page: Page) -> None:
        self.check_holder(page)

    def leave(self, _page: Page) -> None:
        pass

    def described(self, _page: Page) -> dict[str, Any]:
        return self.standing
