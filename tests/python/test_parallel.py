"""Work by several threads, and the runs of sextant-mil that it waits for."""

import threading
import time
from pathlib import Path

import pytest
from sextant_py.errors import UserError
from sextant_py.short_run import run_of, summary_of
from studies.parallel import as_finished, in_order


def test_results_are_in_the_order_of_the_items() -> None:
    steps = []
    items = [0.08, 0.0, 0.04]

    def work(seconds: float) -> float:
        time.sleep(seconds)
        return -seconds

    assert in_order(work, items, 3, lambda: steps.append(1)) == [-0.08, 0.0, -0.04]
    assert len(steps) == 3
    assert [number for number, _ in as_finished(work, items, 3)] == [1, 2, 0]


def test_what_has_not_begun_never_does_after_an_error() -> None:
    begun, gate = [], threading.Event()

    def work(number: int) -> None:
        begun.append(number)
        if number:
            gate.wait(1)
        else:
            raise ValueError("first")

    with pytest.raises(ValueError, match="first"):
        in_order(work, range(50), 2)
    gate.set()
    assert len(begun) < 10


def program(folder: Path, text: str) -> Path:
    file = folder / "sextant-mil"
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)
    return file


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("echo 'sextant-mil: x.toml: no such key' >&2; exit 2", "x.toml: no such key"),
        ("exit 3", "exit status 3"),
        ("exec sleep 5", "no result within 0.3 s"),
    ],
)
def test_a_run_without_a_summary_says_why(tmp_path: Path, text: str, said: str) -> None:
    ended = run_of(program(tmp_path, text), tmp_path / "x.toml", {}, 0.3 if "sleep" in text else 10)
    assert (ended.summary, ended.said) == (None, said)


def test_a_refused_drive_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"x\.toml: sextant-mil refuses the drive: exit status 2\.$"):
        summary_of(program(tmp_path, "exit 2"), tmp_path / "x.toml", {})
