"""NAME.csv.sha256: the SHA-256 of each file of a recording, as `sha256sum --check` reads it; in comments the sizes."""

import hashlib
import re
from pathlib import Path

from ..errors import UserError

LINE = re.compile(r"([0-9a-f]{64})  (.+)")
SIZE = re.compile(r"# (\d+) bytes: (.+)")
Listed = dict[str, tuple[int, str]]  # size and SHA-256 by the file's name


def place_of(path: Path) -> Path:
    return path.with_name(path.name + ".sha256")


def _digest(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def write(path: Path, files: list[Path]) -> None:
    """Of the files of a recording that is closed. OSError leaves none."""
    lines = [f"# {file.stat().st_size} bytes: {file.name}\n{_digest(file)}  {file.name}\n" for file in files]
    place = place_of(path)
    try:
        place.write_text("".join(lines), encoding="utf-8")
    except OSError:
        place.unlink(missing_ok=True)
        raise


def read(path: Path) -> Listed | None:
    """What is listed for the recording; None: it has no checksums. UserError where the list is damaged."""
    place = place_of(path)
    if not place.exists():
        return None
    sizes: dict[str, int] = {}
    listed: Listed = {}
    for number, line in enumerate(place.read_bytes().decode("utf-8", "replace").splitlines(), 1):
        if found := SIZE.fullmatch(line):
            sizes[found[2]] = int(found[1])
        elif found := LINE.fullmatch(line):
            listed[found[2]] = sizes.get(found[2], 0), found[1]
        else:
            raise UserError(
                f"{place}, line {number}: expected a SHA-256 and a file; without {place.name} nothing is verified."
            )
    return listed


def verify(path: Path, listed: Listed, file: Path, is_cut: bool = False) -> None:
    """UserError where the file is not as it was when the recording was closed. One that `is_cut`, as its reader tells,
    cannot have its SHA-256 where it is shorter."""
    place = place_of(path)
    if file.name not in listed:
        raise UserError(f"{place} has no checksum of {file.name}; without {place.name} nothing is verified.")
    if not file.exists():
        raise UserError(f"{file} does not exist, which {place.name} lists; {_unwanted(place)}.")
    size, digest = listed[file.name]
    if is_cut and file.stat().st_size < size:
        return
    if _digest(file) != digest:
        raise UserError(
            f"{file} is damaged or was changed: its SHA-256 is not that in {place.name}; {_unwanted(place)}."
        )


def verify_names(path: Path, listed: Listed, files: list[Path]) -> None:
    """UserError where another file is listed than those of the recording."""
    place = place_of(path)
    if others := sorted(listed.keys() - {file.name for file in files}):
        raise UserError(f"{place} lists {others[0]}, which is no file of a group of {path}; {_unwanted(place)}.")


def _unwanted(place: Path) -> str:
    return f"after a change that is wanted, remove {place.name}"
