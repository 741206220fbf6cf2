"""Result files: what is read is what was written, and a line is a record or an array, not a number."""

import json
import random
import re
from pathlib import Path
from typing import Any

import pytest
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from studies import json_file

KEYS = ["a", "ñ", '"', "\n"]
LONE = re.compile(r"^\s*(-?[\d.]+(e[+-]?\d+)?|null|true|false),?$")


def drawn(draw: random.Random, depth: int) -> Any:
    """A value with containers up to so many levels deep; some are empty."""
    kind = draw.choice(["object", "array", "scalar"]) if depth else "scalar"
    size = draw.randrange(5)
    if kind == "object":
        return {draw.choice(KEYS) + str(n): drawn(draw, depth - 1) for n in range(size)}
    if kind == "array":
        return [drawn(draw, depth - 1) for _ in range(size)]
    return draw.choice([None, True, -3, 1.5e-9, "", "a, {b}", "N·m", "two\nlines"])


@pytest.mark.parametrize("seed", range(200))
def test_what_is_read_is_what_was_written(seed: int, tmp_path: Path) -> None:
    print(f"seed {seed}")
    draw = random.Random(seed)
    value, levels = drawn(draw, 5), draw.randrange(5)
    file = tmp_path / "deep" / "result.json"
    json_file.write(file, value, levels)
    assert json.dumps(json.loads(file.read_text(encoding="utf-8"))) == json.dumps(value)  # with the order of keys


def test_a_record_or_an_array_has_one_line() -> None:
    rows = [{"a": 1, "m": {"x": [1, 2]}}, {"a": 2, "m": {}}]
    value = {"seed": 1, "t": (1, 2.5), "rows": rows, "by": {25: [3], 50: []}}
    lines = ["{", '"seed": 1,', '"t": [1, 2.5],']
    lines += ['"rows": [', '{"a": 1, "m": {"x": [1, 2]}},', '{"a": 2, "m": {}}', "],"]
    lines += ['"by": {', '"25": [3],', '"50": []', "}", "}"]
    assert json_file.text(value).splitlines() == lines
    assert json_file.text(value, levels=0).count("\n") == 1


def test_results_of_the_pages_have_no_line_for_a_single_number() -> None:
    files = sorted((ROOT / "scripts" / "studies").rglob("*.json"))
    assert len(files) > 5
    for file in files:
        lone = [line for line in file.read_text(encoding="utf-8").splitlines() if LONE.match(line)]
        assert not lone, (file, len(lone))


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=r"file/x\.json cannot be written"):
        json_file.write(tmp_path / "file" / "x.json", {})
