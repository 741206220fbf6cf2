"""The documentation: every link and every path of the tree that it names exists."""

import re
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("**/*.md")])
REFERENCE = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)|<img[^>]*\ssrc=\"([^\"]+)\"")
PATH = re.compile(r"(?<![\w./-])((?:apps|cmake|configs|docs|include|scripts|src|tests|\.ci)/[\w./*-]*[\w*])")
HEADING = re.compile(r"^#{1,6}\s+(.*)$", re.MULTILINE)
CODE_BLOCK = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def prose(page: Path) -> str:
    """The page without its blocks of code."""
    return CODE_BLOCK.sub("", page.read_text(encoding="utf-8"))


def links(page: Path) -> list[str]:
    """Targets of links and pictures that lie in the tree."""
    targets = [link or image for link, image in REFERENCE.findall(prose(page))]
    return [target for target in targets if not re.match(r"[a-z]+:", target)]


def named_paths(page: Path) -> set[str]:
    """Paths from the top of the tree, in code blocks as well; `*` stands for any name."""
    return set(PATH.findall(page.read_text(encoding="utf-8")))


def anchors(page: Path) -> set[str]:
    """What the headings of a page can be linked by."""
    headings = (re.sub(r"[`*]|\]\([^)]*\)|\[", "", heading).strip().lower() for heading in HEADING.findall(prose(page)))
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in headings}


def broken_links(page: Path) -> list[str]:
    broken = []
    for target in links(page):
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
            broken.append(target)
    return broken


def missing_paths(page: Path) -> list[str]:
    return sorted(path for path in named_paths(page) if not any(ROOT.glob(path)))


def test_there_are_pages() -> None:
    names = {page.relative_to(ROOT).as_posix() for page in PAGES}
    assert {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/architecture.md", "docs/can.md"} <= names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_link_leads_somewhere(page: Path) -> None:
    assert broken_links(page) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_path_exists(page: Path) -> None:
    assert missing_paths(page) == []


def test_broken_links_and_paths_are_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A page\n[good](page.md#a-page) [gone](gone.md) [no heading](#none) [far](https://example.org)\n"
        "`scripts/demo`, `configs/scenarios/*.toml`, `scripts/no_such_script`\n",
        encoding="utf-8",
    )
    assert broken_links(page) == ["gone.md", "#none"]
    assert missing_paths(page) == ["scripts/no_such_script"]
