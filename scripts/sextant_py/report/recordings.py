"""A recording or a trace in any of its formats, of a live drive, hardware in the loop, virtual time or sextant-mil."""

from pathlib import Path

import numpy as np

from ..recorded_faults import faults_of
from ..recording.model import TRIGGER, Source
from ..recording.topics import STATE
from ..signal_file import GroupRows, SignalFile
from ..telemetry_contract import enumerators
from .model import BAD, NEUTRAL, Fault, Run, Settings, Table, shown
from .pictures import draw

STATISTICS = "statistics"
FAULT = enumerators("DriveStateKind").index("FAULT")
MOST_STATES = 100  # rows
COUNTS = ("periods", "periods_missed", "overruns", "overruns_own_execution", "page_faults", "telemetry_dropped",
          "commands_received", "commands_rejected")  # fmt: skip
LARGEST = ("wake_latency_p99_99_us", "wake_latency_max_us", "execution_p99_99_us", "execution_max_us")


def _groups(file: SignalFile) -> Table:
    rows = ((name, str(file.groups[name].count), file.groups[name].group.text) for name in file.filled())
    return Table("Groups", ("group", "rows", "meaning"), tuple(rows), (0, 2))


def _states(rows: GroupRows) -> Table:
    names = enumerators("DriveStateKind")
    columns = rows.time_s, rows.values("state").tolist(), rows.values("reason").tolist()
    listed = [
        (shown(float(t_s)), names[state] if state < len(names) else str(state), _text(reason))
        for t_s, state, reason in zip(*columns, strict=True)
    ]
    more = len(listed) - MOST_STATES
    note = f"{more} further changes are left out." if more > 0 else ""
    return Table("States of the drive", ("time [s]", "state", "reason"), tuple(listed[:MOST_STATES]), (1, 2), note)


def _text(value: bytes | str) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _real_time(rows: GroupRows) -> Table:
    """Counts at the end, and the largest of the figures of each second."""
    known = rows.group.dtype.names or ()
    texts = {column.name: f"{column.text} [{column.unit}]" for column in rows.group.columns}
    listed = [(name, shown(rows.values(name)[-1].item()), texts[name]) for name in COUNTS if name in known]
    for name in LARGEST:
        if name in known:
            listed.append((name, shown(float(np.max(rows.values(name)))), f"largest: {texts[name]}"))
    return Table("Real time", ("figure", "value", "meaning"), tuple(listed), (0, 2))


def _losses(losses: dict[str, dict[str, int]]) -> Table | None:
    heads = ("rows", "lost", "dropped", "periods_missing", "restarts")
    listed = tuple((name, *(str(of.get(head, 0)) for head in heads)) for name, of in losses.items())
    return Table("What is missing", ("group", *heads), listed) if listed else None


def _facts(run: Run, source: Source, file: SignalFile) -> None:
    metadata = source.metadata
    attributes = metadata.get("attributes", {})
    named = {"drive_id": "drive", "can": "CAN bus", "trigger": "trigger", "program": "written by"}
    run.facts = [(text, shown(metadata[key])) for key, text in named.items() if metadata.get(key) is not None]
    attributed = {"scenario": "scenario", "mode": "mode", "control_period_ns": "control period [ns]"}
    run.facts += [(text, shown(attributes[key])) for key, text in attributed.items() if key in attributes]
    run.versions = [("sextant", attributes[key]) for key in ("sextant_version",) if key in attributes]
    if TRIGGER in metadata:
        run.facts.append(("time zero", "the trigger"))
    time_s = file.groups[file.main].time_s
    run.facts.append(("length [s]", shown(float(time_s[-1] - time_s[0]))))


def read(path: Path, settings: Settings) -> Run:
    file = SignalFile(path)
    source = file.groups[file.main].source
    kind = "trace" if "scenario" in source.metadata.get("attributes", {}) else "recording"
    run = Run(path.stem if path.stem != "trace" else path.parent.name, kind, path, "recorded")
    filled = file.filled()
    main = file.groups[file.main]
    if STATE in filled or "state" in (main.group.dtype.names or ()):
        run.faults = [Fault(fault.name, fault.t_s) for fault in faults_of(file)]
        states = file.groups[STATE if STATE in filled else file.main].values("state")
        run.verdict = "in FAULT at the end" if states[-1] == FAULT else "recorded"
        run.result = BAD if states[-1] == FAULT else NEUTRAL
    run.notes += [f"{sentence}." for sentence in (source.cut, source.unverified) if sentence]
    _facts(run, source, file)
    draw(run, path, settings)
    if STATE in filled:
        run.tables.append(_states(file.groups[STATE]))
    if STATISTICS in filled:
        run.tables.append(_real_time(file.groups[STATISTICS]))
    if losses := _losses(source.metadata.get("losses", {})):
        run.tables.append(losses)
    run.tables.append(_groups(file))
    return run
