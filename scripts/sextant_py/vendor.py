"""JavaScript of others that pages load: scripts/setup fetches it into folders beside these pages."""

from pathlib import Path

from .errors import UserError

LOCK = "package-lock.json"  # with the versions and hashes of what is there, once all of it is


def need(page: str, folder: Path) -> None:
    """Refuses to go on without the files of a page's `folder`."""
    if not (folder / LOCK).is_file():
        raise UserError(
            f"{page} lacks JavaScript that it loads, in {folder}; scripts/setup fetches it, and has to run before pip"
            " installs the package."
        )
