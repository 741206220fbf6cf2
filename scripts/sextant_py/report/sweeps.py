"""The directory of a sweep: how its points turned out, and its pictures."""

import json
from collections import Counter
from pathlib import Path

from ..errors import UserError
from ..sweep_point import EXPECT_FAILED, FAILED, OK
from .model import BAD, GOOD, Picture, Run, Table, shown
from .pictures import data_uri

STATE, POINTS, TABLE = "sweep.json", "points.jsonl", "table.parquet"
MOST_FAILED = 40  # points that are listed
WORDS = {OK: "all limits hold", EXPECT_FAILED: "a limit does not hold", FAILED: "failed"}


def _points(directory: Path) -> list[dict]:
    """The finished points; the end of a file that was cut off is passed over."""
    text = (directory / POINTS).read_text(encoding="utf-8") if (directory / POINTS).is_file() else ""
    points = []
    for line in text.split("\n")[:-1]:
        point = json.loads(line)
        if point["status"] not in WORDS:
            raise ValueError(line)
        points.append(point)
    return sorted(points, key=lambda point: point["point"])


def _keys(directory: Path) -> dict[int, str]:
    """What varies, with its value, of each point of the table."""
    if not (directory / TABLE).is_file():
        return {}
    from pyarrow import parquet

    table = parquet.read_table(directory / TABLE)
    names = [name for name in table.column_names if "." in name or name in ("duration_s",)]
    rows = table.select(["point", *names]).to_pylist()
    return {row["point"]: ", ".join(f"{name} = {shown(row[name])}" for name in names) for row in rows}


def _pictures(directory: Path) -> list[Picture]:
    found = []
    for file in sorted(directory.glob("*.png")):
        uri = data_uri(file.read_bytes())
        found.append(Picture(file.stem, {(n, d): uri for n in (False, True) for d in (False, True)}))
    return found


def read(directory: Path) -> Run:
    try:
        state = json.loads((directory / STATE).read_text(encoding="utf-8"))
        name, total, points = state["name"], state["points"], _points(directory)
        keys = _keys(directory)
        bad = [point for point in points if point["status"] != OK]
        rows = tuple((str(p["point"]), keys.get(p["point"], ""), WORDS[p["status"]], p["reason"]) for p in bad)
    except OSError as error:
        raise UserError(f"{error.filename or directory} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError):
        raise UserError(f"{directory} holds no whole result of scripts/sweep.") from None
    counts = Counter(point["status"] for point in points)
    is_good = counts[OK] == total
    run = Run(name, "sweep", directory, "pass" if is_good else "fail", GOOD if is_good else BAD)
    if len(points) < total:
        run.verdict = "not finished"
    run.points = f"{counts[OK]} of {total} points"
    listed = tuple((word, str(counts[status])) for status, word in WORDS.items())
    run.tables.append(Table("Points", ("result", "points"), listed))
    run.facts = [("scenario", state.get("scenario", "–")), ("points", f"{len(points)} of {total}")]
    if state.get("seed") is not None:
        run.facts.append(("seed", str(state["seed"])))
    more = f"{len(rows) - MOST_FAILED} further points are in points.jsonl." if len(rows) > MOST_FAILED else ""
    if rows:
        head = ("point", "with", "result", "reason")
        run.tables.append(Table("Points that did not pass", head, rows[:MOST_FAILED], (1, 2, 3), more))
    run.pictures = _pictures(directory)
    return run
