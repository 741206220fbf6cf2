"""A result directory of sextant-mil: its summary, and its trace where there is one."""

from pathlib import Path
from typing import Any

from ..comparison import read_summary
from ..errors import UserError
from .configuration import Configuration, differences, metric_texts, print_config
from .model import BAD, GOOD, NEUTRAL, Check, Fault, Run, Settings, Table, shown
from .pictures import draw

GOOD_VERDICTS, NEUTRAL_VERDICTS = ("pass",), ("nothing_expected",)


def limit_text(limit: dict[str, float]) -> str:
    low, high = limit.get("min"), limit.get("max")
    if low is None:
        return f"≤ {shown(high)}"
    return f"≥ {shown(low)}" if high is None else f"{shown(low)} … {shown(high)}"


def window_text(window: dict[str, float | None]) -> str:
    end = "to the end" if window["to_s"] is None else f"to {shown(window['to_s'])} s"
    return f"from {shown(window['from_s'])} s {end}"


def _checks(summary: dict[str, Any]) -> list[Check]:
    checks = []
    if expected := summary.get("expected_fault"):
        result = GOOD if expected["pass"] else BAD
        first = summary["faults"][0]["fault"] if summary.get("faults") else "none"
        checks.append(Check("first fault", expected["fault"], first, result, window_text(expected)))
    for row in summary.get("expect", []):
        about = window_text(row["window"]) if "window" in row else ""
        limit, value = limit_text(row["limit"]), shown(row["value"])
        checks.append(Check(row["metric"], limit, value, GOOD if row["pass"] else BAD, about))
    return checks


def _metrics(summary: dict[str, Any], texts: dict[str, str]) -> Table:
    """Those that the run has a value of."""
    found = [(name, value) for name, value in summary["metrics"].items() if value is not None]
    if not texts:
        return Table("Metrics", ("metric", "value"), tuple((name, shown(value)) for name, value in found))
    rows = tuple((name, shown(value), texts.get(name, "")) for name, value in found)
    return Table("Metrics", ("metric", "value", "meaning"), rows, (0, 2))


def _configuration(configuration: Configuration, settings: Settings) -> Table:
    """Without what stands elsewhere: name, description and limits."""
    head, title = ("key", "value", "default", "meaning"), "Configuration: what differs from the defaults"
    found = differences(settings.program, configuration)
    rows = tuple(
        (entry.key, shown(entry.value), entry.default_text, entry.about)
        for entry in found
        if entry.key not in ("name", "description") and not entry.key.startswith("expect.")
    )
    note = f"{len(configuration) - len(found)} other keys have their defaults; the limits of [expect] stand above."
    return Table(title, head, rows, (0, 1, 2, 3), note)


def _whole(configuration: Configuration) -> Table:
    rows = tuple((key, shown(value)) for key, value in configuration.items() if value is not None)
    return Table("Configuration", ("key", "value"), rows, (0, 1))


def _add_tables(run: Run, summary: dict[str, Any], settings: Settings) -> None:
    configuration, texts = summary.get("configuration"), {}
    tables = []
    if configuration:
        try:
            machine = {key: value for key, value in configuration.items() if key.startswith("machine.")}
            texts = metric_texts(print_config(settings.program, {"name": "report", "duration_s": 1.0, **machine}))
            tables.append(_configuration(configuration, settings))
        except UserError as error:
            run.notes.append(f"The whole configuration is shown, without its defaults: {error}")
            tables.append(_whole(configuration))
    run.tables += [_metrics(summary, texts), *tables]


def read(path: Path, settings: Settings) -> Run:
    """path: a result directory or its summary.json."""
    file = path / "summary.json" if path.is_dir() else path
    summary = read_summary(file)
    verdict = summary["verdict"]
    result = GOOD if verdict in GOOD_VERDICTS else NEUTRAL if verdict in NEUTRAL_VERDICTS else BAD
    run = Run(summary["scenario"], "run of sextant-mil", path, verdict.replace("_", " "), result)
    configuration = summary.get("configuration", {})
    run.description = configuration.get("description") or ""
    run.reasons = [summary[key] for key in ("problem", "trace_error") if summary.get(key)]
    run.checks = _checks(summary)
    if "faults" in summary:
        run.faults = [Fault(entry["fault"], entry["t_s"]) for entry in summary["faults"]]
    run.versions = [("sextant-mil", " ".join(summary[key] for key in ("version", "commit") if summary.get(key)))]
    facts = {
        "duration_s": "length [s]",
        "control.controller": "control method",
        "drive.period_us": "control period [µs]",
    }
    run.facts = [(text, shown(configuration[key])) for key, text in facts.items() if key in configuration]
    trace = file.with_name("trace.h5")
    if trace.is_file():
        draw(run, trace, settings)
    else:
        run.notes.append("There is no trace.h5 beside the summary, so nothing is drawn.")
    _add_tables(run, summary, settings)
    return run
