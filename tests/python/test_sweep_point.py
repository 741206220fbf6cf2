"""What a run of sextant-mil means for its point."""

import json
from pathlib import Path

import pytest
from sextant_py import sweep_point

METRICS = {"torque_bias_nm": -4.25, "response_time_ms": None}
HELD = {"metric": "torque_bias_nm", "limit": {"min": -5.0}, "value": -4.25, "pass": True}
MISSED = {"metric": "torque_bias_nm", "limit": {"min": -3.0, "max": 1.0}, "value": -4.25, "pass": False}
WITHOUT = {"metric": "response_time_ms", "limit": {"max": 5.0}, "value": None, "pass": False}
TRIPPED = "sextant-mil: reversal: the drive tripped with over_current at 0.1 s; see [protection] and [command]\n"


def summary(verdict: str, *rows: dict) -> dict:
    return {"scenario": "x", "verdict": verdict, "metrics": METRICS, "expect": list(rows)}


@pytest.mark.parametrize(
    ("status", "said", "found", "expected"),
    [
        (0, "", summary("pass", HELD), ("ok", "")),
        (0, "", summary("nothing_expected"), ("ok", "")),
        (1, "", summary("fail", HELD, MISSED),
         ("expect_failed", "torque_bias_nm is -4.25, expected min -3 and max 1")),
        (1, "", summary("fail", WITHOUT), ("expect_failed", "response_time_ms is no value, expected max 5")),
        (1, "sextant-mil: x: OVER_SPEED was expected and did not come\n", summary("fail", HELD),
         ("failed", "x: OVER_SPEED was expected and did not come")),
        (3, TRIPPED, summary("tripped", MISSED),
         ("failed", "reversal: the drive tripped with over_current at 0.1 s; see [protection] and [command]")),
        (4, "sextant-mil: x: torque was asked\n", summary("no_torque", MISSED), ("failed", "x: torque was asked")),
        (1, "", summary("fail", HELD), ("failed", "sextant-mil left exit status 1 and no reason")),
        (0, "", summary("interrupted", HELD), ("failed", "sextant-mil left exit status 0 and no reason")),
        (2, "sextant-mil: --set: a: bad\n--set: b: bad\n", None, ("failed", "--set: a: bad; --set: b: bad")),
        (0, "", None, ("failed", "sextant-mil left no summary and exit status 0")),
        (7, "", summary("not_balanced", MISSED), ("failed", "sextant-mil left exit status 7 and no reason")),
        (2, "", summary("pass", HELD), ("failed", "sextant-mil left exit status 2")),
        (130, "", summary("interrupted", HELD), ("failed", "sextant-mil left exit status 130")),
        (-11, "", summary("pass", HELD), ("failed", "sextant-mil was ended by signal SIGSEGV")),
        (-6, "what(): no\n", None, ("failed", "sextant-mil was ended by signal SIGABRT; what(): no")),
        (127, "", None, ("failed", "sextant-mil left no summary and exit status 127")),
    ],
)  # fmt: skip
def test_status_and_reason(status: int, said: str, found: dict | None, expected: tuple[str, str]) -> None:
    assert sweep_point.judge(status, said, found) == expected
    own = sweep_point.judge(status, said.replace("sextant-mil", "own-mil"), found, "own-mil")
    assert own == tuple(text.replace("sextant-mil", "own-mil") for text in expected)


def test_reasons_are_short() -> None:
    assert len(sweep_point.clean_reason("long " * 1000)) == sweep_point.LONGEST_REASON + 1


def test_summaries(tmp_path: Path) -> None:
    assert sweep_point.read_summary(tmp_path) is None
    file = tmp_path / "summary.json"
    for text in ("", "[]", "{}", '{"metrics": [], "expect": []}', '{"metrics": {}'):
        file.write_text(text)
        assert sweep_point.read_summary(tmp_path) is None, text
    file.write_text(json.dumps(summary("pass", HELD)))
    assert sweep_point.read_summary(tmp_path)["metrics"] == METRICS
