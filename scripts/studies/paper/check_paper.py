"""Runs a part of the paper's scenarios again and compares with the numbers of docs/paper."""

import sys
from dataclasses import replace
from pathlib import Path

from sextant_py import mil_program
from sextant_py.errors import run
from sextant_py.paths import ROOT

from . import defaults, paper_report
from .lab import Lab
from .numbers import Numbers, differences
from .page import render

COMMITTED = ROOT / "docs" / "paper"


def page_differences(directory: Path, numbers: Numbers) -> list[str]:
    """The page must be what its numbers make of the template, and its pictures must be there."""
    page = directory / "README.md"
    written = page.read_text(encoding="utf-8") if page.is_file() else ""
    wanted = render(numbers)
    found = []
    if written != wanted:
        pairs = zip(written.splitlines(), wanted.splitlines(), strict=False)
        line = next((k for k, (a, b) in enumerate(pairs, 1) if a != b), "its end")
        found.append(f"{page.name}: line {line} is not what numbers.json makes of it; scripts/paper_report --page does")
    for name in paper_report.PICTURES:
        if not (directory / f"{name}.png").is_file():
            found.append(f"{name}.png is missing; scripts/paper_report draws it")
    return found


def changed(numbers: Numbers, name: str) -> Numbers:
    """The same with one number off by three tolerances."""
    number = numbers.entries[name]
    entries = numbers.entries | {name: replace(number, value=number.value + 3 * (number.tolerance or 1))}
    return Numbers(entries)


def self_test(committed: Numbers, now: Numbers) -> list[str]:
    """What a changed number would have slipped through."""
    slipped = []
    for name in now.entries:
        number = committed.entries[name]
        if number.tolerance and number.value == number.value and not differences(changed(committed, name), now):
            slipped.append(f"{name}: a change of three tolerances was not found")
    on_page = "response/centred/dead/15"
    if render(changed(committed, on_page)) == render(committed):
        slipped.append(f"{on_page}: a change does not show on the page")
    return slipped


def main(arguments: list[str]) -> int:
    parser = paper_report.parser_of(
        "check_paper", "Runs a part of the paper's scenarios again and compares with docs/paper."
    )
    parser.add_argument("--self-test", action="store_true", help="every number of the part, changed, must be found")
    options = parser.parse_args(arguments)
    committed, now = Numbers.load(paper_report.NUMBERS), Numbers()
    with Lab(mil_program.find(options.mil), options.jobs) as lab:
        paper_report.measure(lab, now, True, lambda _: None)
    if options.self_test:
        found = self_test(committed, now)
        good = f"found: a changed number, whichever of {len(now.entries)}"
    else:
        found = differences(committed, now) + defaults.gone(committed, now)
        found += page_differences(COMMITTED, committed)
        good = f"docs/paper: {len(now.entries)} of its {len(committed.entries)} numbers measured again, all hold."
    for sentence in found:
        print(f"check_paper: {sentence}", file=sys.stderr)
    if not found:
        print(good)
    return 1 if found else 0


if __name__ == "__main__":
    run("check_paper", main)
