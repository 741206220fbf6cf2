"""The paired runs of the live drive: their order, and what is added up."""

import argparse

import pytest
from rich.console import Console
from sextant_py import compare_live
from sextant_py.compare_live import Run


def test_each_round_begins_with_the_other_integrator(monkeypatch: pytest.MonkeyPatch) -> None:
    order: list[str] = []

    def drive(_: argparse.Namespace, integrator: str) -> Run:
        order.append(integrator)
        return Run(480_000, len(order), 1, 0, {"p50_ns": 1e5, "p99_ns": 2e5})

    monkeypatch.setattr(compare_live, "drive", drive)
    found = compare_live.in_turns(compare_live.parse_arguments(["--rounds", "3"]))
    assert order == ["cvode", "fixed", "fixed", "cvode", "cvode", "fixed"]
    assert [one.missed for one in found["cvode"]] == [1, 4, 5]


def test_the_table_adds_the_rounds_up() -> None:
    one = Run(100, 3, 2, 1, {"p50_ns": 150e3, "p99_ns": 300e3})
    other = Run(200, 0, 0, 0, {"p50_ns": 120e3, "p99_ns": 310e3})
    console = Console(width=100, record=True, quiet=False)
    console.print(compare_live.table_of({"cvode": [one, other], "fixed": [other, other]}))
    rows = [line.split("│") for line in console.export_text().splitlines() if line.startswith("│")]
    cells = {row[1].strip(): [cell.strip() for cell in row[2:4]] for row in rows}
    assert cells == {
        "periods": ["300", "400"],
        "missed": ["3 (3, 0)", "0 (0, 0)"],
        "overruns": ["2", "0"],
        "of these by the drive's own execution": ["1", "0"],
        "execution of a wake-up, median": ["120 µs", "120 µs"],
        "execution of a wake-up, 99 %": ["300 µs", "310 µs"],
    }


def test_no_round_is_refused(capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        compare_live.parse_arguments(["--rounds", "0"])
    assert "--rounds: expected a number from 1, got 0" in capsys.readouterr().err
