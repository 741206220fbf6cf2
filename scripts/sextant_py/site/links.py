"""Markdown as GitHub shows it, for a site: links to other parts of the tree, and lists."""

import os.path
import re
from pathlib import Path

from ..paths import ROOT

DOCS = ROOT / "docs"
# Pages of the tree that have a place of their own in the site.
PLACES = {
    ROOT / "README.md": "index.md",
    ROOT / "CONTRIBUTING.md": "contributing.md",
    ROOT / "CHANGELOG.md": "changelog.md",
}
_LINK = re.compile(r"(!?\[[^\]\n]*\]\()([^)\s]+)((?:\s+\"[^\"]*\")?\))")
_FENCE = re.compile(r"(^ *```.*?^ *```[ \t]*$)", re.MULTILINE | re.DOTALL)
_NESTED = re.compile(r"^ {2,3}(?=[-*] |\d+\. )", re.MULTILINE)
_LIST = re.compile(r"^(?:[-*]|\d+\.) ")


def place_of(file: Path) -> str:
    """The path within the site's Markdown of a file or a directory of the tree."""
    if file in PLACES:
        return PLACES[file]
    if file.is_relative_to(DOCS) and file.is_file():
        return file.relative_to(DOCS).as_posix()
    return f"source/{file.relative_to(ROOT).as_posix()}.md"


def target_of(origin: Path, link: str) -> Path | None:
    """The file of the tree that a link of a page leads to; None for another page's network address or an anchor."""
    name = link.partition("#")[0]
    if not name or re.match(r"[a-z]+:", name):
        return None
    file = Path(os.path.normpath(origin.parent / name))
    return file if file.is_relative_to(ROOT) else None


def split(text: str) -> list[str]:
    """Prose and blocks of code in turns, prose first."""
    return _FENCE.split(text)


def rewritten(text: str, origin: Path, place: str) -> str:
    """The links of a page as they are from its place in the site."""

    def replaced(link: re.Match) -> str:
        target = target_of(origin, link[2])
        if target is None or not target.exists():
            return link[0]
        anchor = link[2].partition("#")[1:]
        there = os.path.relpath(place_of(target), Path(place).parent)
        return f"{link[1]}{there}{''.join(anchor)}{link[3]}"

    parts = split(text)
    parts[::2] = [lists(_LINK.sub(replaced, part)) for part in parts[::2]]
    return "".join(parts)


def lists(text: str) -> str:
    """GitHub takes a list without a blank line before it and nested by two spaces; Python-Markdown does not."""
    lines: list[str] = []
    for line in _NESTED.sub("    ", text).split("\n"):
        before = lines[-1] if lines else ""
        if _LIST.match(line) and before.strip() and not _LIST.match(before) and not before.startswith(" "):
            lines.append("")
        lines.append(line)
    return "\n".join(lines)


def linked_sources(pages: dict[str, Path]) -> set[Path]:
    """The files and directories outside docs/ that pages link to."""
    found: set[Path] = set()
    for origin in pages.values():
        for part in split(origin.read_text(encoding="utf-8"))[::2]:
            targets = {target_of(origin, link[2]) for link in _LINK.finditer(part)}
            found |= {target for target in targets if target and place_of(target).startswith("source/")}
    return {target for target in found if target.exists()}
