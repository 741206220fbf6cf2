"""scripts/check_instructions: what is found, what is not tested, and how it is said."""

import json
from pathlib import Path

import pytest
from sextant_py.errors import UserError
from studies.bench import instructions

HERE = {"compiler": "g++ 12", "libc": "glibc 2.36"}


def test_a_step_is_what_more_steps_add() -> None:
    assert instructions.per_step(lambda n: 1_000_000 + 202 * n, 1920) == 202.0


@pytest.mark.parametrize("change", [1.0, 1.0199, 0.9801])
def test_within_two_per_cent_nothing_is_found(change: float) -> None:
    assert instructions.judge({"step": 1000.0}, {"step": 1000.0 * change}) == []


@pytest.mark.parametrize(
    ("now", "sentence"),
    [
        ({"step": 1021.0}, "step grew from 1000 to 1021 instructions a step (+2.1 %)."),
        ({"step": 979.0}, "step fell from 1000 to 979 instructions a step (-2.1 %)."),
        ({}, "step is in the baseline and no longer counted."),
        ({"step": 1000.0, "other": 1.0}, "other is new and not in the baseline."),
    ],
)
def test_what_leaves_its_place_is_named(now: dict, sentence: str) -> None:
    assert instructions.judge({"step": 1000.0}, now) == [sentence]


@pytest.fixture
def baseline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(instructions, "environment", lambda _: HERE)
    file = tmp_path / "instructions.json"
    file.write_text(json.dumps({"environment": HERE, "instructions_per_step": {"step": 1000.0}}))
    return file


def counted(monkeypatch: pytest.MonkeyPatch, value: float) -> None:
    monkeypatch.setattr(instructions, "measure", lambda *_: {"step": value})


def test_growth_fails_and_says_how_to_accept(
    baseline: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    counted(monkeypatch, 1050.0)
    assert instructions.check(Path("probe"), baseline) == 1
    printed = capsys.readouterr().out
    assert "step grew from 1000 to 1050" in printed
    assert "scripts/check_instructions --update" in printed
    assert instructions.update(Path("probe"), baseline) == 0
    assert instructions.check(Path("probe"), baseline) == 0


def test_another_compiler_is_not_judged_and_says_so(
    baseline: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    counted(monkeypatch, 2000.0)
    monkeypatch.setattr(instructions, "environment", lambda _: HERE | {"compiler": "g++ 13"})
    assert instructions.check(Path("probe"), baseline) == 0
    assert "!!! NOT TESTED" in (printed := capsys.readouterr().out)
    assert "compiler: g++ 12 there, g++ 13 here" in printed


def test_a_missing_baseline_says_what_writes_it(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="--update writes it"):
        instructions.check(Path("probe"), tmp_path / "none.json")


def test_the_self_test_fails_where_a_seed_is_not_found(monkeypatch: pytest.MonkeyPatch) -> None:
    counted(monkeypatch, 1000.0)  # as if the seed did nothing
    with pytest.raises(UserError, match=r"a slow-down of 5 % was not found in step"):
        instructions.self_test(Path("probe"))
