"""The documentation as a site: built strictly, complete, without a network, every link within it leading somewhere."""

import re
import shutil
import subprocess
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

import cantools
import pytest
from sextant_py.paths import DBC, IDL, ROOT
from sextant_py.site import links, reference


class Page(HTMLParser):
    """What a page links to, what it loads, what it can be linked by, and its text."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.pictures: list[str] = []
        self.anchors: set[str] = set()
        self.text = ""
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if tag == "link" and "stylesheet" in found.get("rel", ""):
            self.loads.append(found["href"])
        if tag in ("script", "img", "iframe", "source") and "src" in found:
            self.loads.append(found["src"])
        if tag == "img":
            self.pictures.append(found["src"])

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    done = subprocess.run([ROOT / "scripts" / "docs", "--out", out], capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{out / 'index.html'}\n"
    return out


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    """404.html is for servers alone: its links begin at their root."""
    return {file: Page(file) for file in site.rglob("*.html") if file.name != "404.html"}


def test_every_picture_opens_in_its_own_size(pages: dict[Path, Page]) -> None:
    found = [(page, picture) for page in pages.values() for picture in page.pictures]
    assert len(found) > 30
    assert [picture for page, picture in found if picture not in page.links] == []


def test_symbols_are_set(pages: dict[Path, Page]) -> None:
    found = re.compile(r"\$[A-Za-z]_[a-z]\$")
    assert [file.name for file, page in pages.items() if "source" not in file.parts and found.search(page.text)] == []


def test_every_page_of_the_documentation_is_there(site: Path, pages: dict[Path, Page]) -> None:
    navigation = pages[site / "index.html"].links
    for page in (ROOT / "docs").glob("**/*.md"):
        place = page.relative_to(ROOT / "docs").with_suffix(".html").as_posix().replace("README.html", "index.html")
        assert (site / place).is_file(), place
        assert place in navigation, f"{place} is not in the navigation of mkdocs.yml"


def test_nothing_is_loaded_from_a_network(pages: dict[Path, Page]) -> None:
    for file, page in pages.items():
        for load in page.loads:
            assert not re.match(r"(?:[a-z]+:)?//", load), (file, load)
            assert (file.parent / urllib.parse.unquote(load.partition("?")[0])).is_file(), (file, load)


def test_every_link_leads_somewhere(pages: dict[Path, Page]) -> None:
    checked = 0
    for file, page in pages.items():
        for link in page.links:
            name, _, anchor = link.partition("#")
            if re.match(r"(?:https?|mailto):", name):
                continue
            target = (file.parent / urllib.parse.unquote(name)).resolve() if name else file
            assert target.is_file(), (file, link)
            if anchor and target.suffix == ".html":
                assert urllib.parse.unquote(anchor) in pages[target].anchors | {"__skip"}, (file, link)
            checked += 1
    assert checked > 1000


def test_the_reference_has_every_message_and_every_member(site: Path, pages: dict[Path, Page]) -> None:
    messages = pages[site / "reference" / "can.html"].text
    for message in cantools.database.load_file(DBC).messages:
        assert f"0x{message.frame_id:03X} {message.name}" in messages
        assert all(signal.name in messages for signal in message.signals)
    topics = pages[site / "reference" / "telemetry.html"].text
    members = re.findall(r"^ {4}(?:@key )?[\w<>, ]+ _?(\w+);", IDL.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(members) > 80
    assert all(member in topics for member in members)
    commands = pages[site / "reference" / "commands.html"].text
    assert "usage: plot" in commands and "usage: compare" in commands
    headers = pages[site / "reference" / "headers.html"].text
    for header in (ROOT / "include" / "sextant").glob("*/*.hpp"):
        assert f"sextant/{header.parent.name}/{header.name}" in headers


def test_sources_are_shown_as_they_are(site: Path, pages: dict[Path, Page]) -> None:
    page = pages[site / "source" / "include" / "sextant" / "core" / "drive_io.hpp.html"]
    source = (ROOT / "include" / "sextant" / "core" / "drive_io.hpp").read_text(encoding="utf-8").strip()
    assert source in page.text


def test_links_of_the_tree_become_links_of_the_site() -> None:
    text = "[a](../include/sextant/core) [b](can.md#messages) [c](../README.md#map) [d](https://x.org)"
    assert links.rewritten(text, ROOT / "docs" / "torque.md", "torque.md") == (
        "[a](source/include/sextant/core.md) [b](can.md#messages) [c](index.md#map) [d](https://x.org)"
    )
    code = "```cpp\n[](int x)\n- no list\n```\n"
    assert links.rewritten(code, ROOT / "docs" / "torque.md", "torque.md") == code


def test_lists_are_those_of_github() -> None:
    assert links.lists("Text:\n- a\n- b\n   - c\n\n1. d\n  - e") == "Text:\n\n- a\n- b\n    - c\n\n1. d\n    - e"


def test_the_first_sentence_of_a_header() -> None:
    text = "#pragma once\n\n/// A thing that counts. It starts\n/// at zero.\ntemplate <class T>\nclass Thing {\n"
    assert reference.first_sentence(text) == "A thing that counts."
    assert reference.first_sentence("#pragma once\nint x;\n") == ""


def test_a_link_that_leads_nowhere_ends_the_build(tmp_path: Path) -> None:
    """In a copy of the checkout in which one page has such links."""
    copied, left = ("docs", "scripts", "mkdocs.yml"), ("out", "build", ".git", ".cache")
    for entry in ROOT.iterdir():
        if entry.is_dir() and entry.name in copied:
            shutil.copytree(entry, tmp_path / entry.name, ignore=shutil.ignore_patterns("__pycache__"))
        elif entry.is_file():
            shutil.copy(entry, tmp_path)
        elif entry.name not in left:
            (tmp_path / entry.name).symlink_to(entry)
    with (tmp_path / "docs" / "sensors.md").open("a", encoding="utf-8") as page:
        page.write("\n[a](none.md) [b](torque.md#no-such-heading)\n")
    command = [tmp_path / "scripts" / "docs", "--out", tmp_path / "site"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    assert "'none.md'" in done.stderr
    assert "no-such-heading" in done.stderr
    assert done.stderr.endswith("is not complete; the lines above say why.\n")
