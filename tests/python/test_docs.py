"""The documentation: every link and every path of the tree that it names exists."""

import re
from pathlib import Path

import pytest
from programs import modules_called
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


def test_every_gate_is_in_the_table_and_says_whether_it_tests_itself() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| [^|]+ \| `scripts/(check_\w+)[^|]*\|([^|]*)\|", page, re.MULTILINE))
    assert sorted(rows) == sorted(file.name for file in (ROOT / "scripts").glob("check_*"))
    for gate, tests_itself in rows.items():
        text = (ROOT / "scripts" / gate).read_text(encoding="utf-8")
        for module in modules_called(gate):
            text += (ROOT / "scripts" / module.replace(".", "/")).with_suffix(".py").read_text(encoding="utf-8")
        assert (tests_itself.strip() == "yes") == ("--self-test" in text), gate


def test_ci_runs_every_gate() -> None:
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    in_ctest = {"check_function_effects"}
    in_nightly = {"check_control_thread_audit", "check_coverage", "check_stalled_host", "check_recording"}
    for gate in {file.name for file in (ROOT / "scripts").glob("check_*")} - in_ctest - in_nightly:
        assert re.search(rf"^stage \w+ scripts/{gate}( .+)?$", run, re.MULTILINE), gate
    nightly = (ROOT / "scripts" / "nightly").read_text(encoding="utf-8")
    for gate in in_nightly:
        assert f"gate scripts/{gate}" in nightly, gate


def test_every_suppression_of_function_effects_is_listed() -> None:
    sources = [file for folder in ("include", "src", "apps") for file in (ROOT / folder).glob("**/*.[hc]pp")]
    suppressed = {
        file.relative_to(ROOT).as_posix()
        for file in sources
        if file.name != "nonblocking.hpp" and "SEXTANT_TRUSTED_BEGIN" in file.read_text(encoding="utf-8")
    }
    page = (ROOT / "docs" / "realtime.md").read_text(encoding="utf-8")
    section = page.split("\n### Real-time safety checks\n")[1].split("\n##")[0]
    entries = "\n".join(re.findall(r"^- .*$", section, re.MULTILINE))
    listed = {link.removeprefix("../") for link in re.findall(r"\]\((\.\./[^)]*\.[hc]pp)\)", entries)}
    assert suppressed == listed
