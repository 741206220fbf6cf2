"""What stands in the place of the desk where pages have no token: nothing that they send reaches the vehicle."""

from typing import Any

from .access import Access
from .command_desk import WRONG_TOKEN, CommandDesk, Page, RefusedError


class Onlookers(CommandDesk):
    """Shows who commands. No page ever does, so that it refuses every command."""

    def __init__(self, standing: dict[str, Any]) -> None:
        """standing: what the desk says of commanding, for any page."""
        super().__init__(Access("", None), None)
        self.standing = standing

    def take(self, page: Page, token: object) -> None:
        if self.standing["allowed"]:
            raise RefusedError(WRONG_TOKEN)
        super().take(page, token)

    def described(self, _page: Page) -> dict[str, Any]:
        return self.standing
