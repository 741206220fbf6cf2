"""The page of the study over the library of machines, from its results."""

import re
from collections import Counter
from pathlib import Path

from sextant_py.control_methods import METHODS

from studies.page import filled, table
from studies.plant_faults import injections_table

from . import scenarios
from .figure import draw
from .points import PERIODS_US
from .results import DERATED, OUTCOMES, REFUSED, RIGHT, TRIPPED, WRONG, Results, causes, counts

TEMPLATE = Path(__file__).with_name("page.md")
SHOWN = 20  # points that are listed


def _size(machine: dict) -> tuple:
    return f"{machine['power_w'] / 1e3:.3g}", f"{machine['voltage']:.0f}", machine["poles"]


def _kinds(found: Counter) -> tuple[int, ...]:
    return tuple(found[kind] for kind in OUTCOMES)


def machines_table(results: Results) -> str:
    head = ("machine", "kW", "V", "poles", *OUTCOMES, "derated without need")
    found = counts(results.outcomes, lambda one: one.machine)
    rows = []
    for machine in results.machines:
        own = found.get(machine["id"], Counter())
        rows.append((machine["name"], *_size(machine), *_kinds(own), own["needless"]))
    total = sum(found.values(), Counter())
    return table(head, [*rows, ("**all**", "", "", "", *_kinds(total), total["needless"])])


def methods_table(results: Results) -> str:
    """Points that are not right, of all, by method and period."""
    found = counts(results.outcomes, lambda one: (one.method, one.period_us))
    rows = []
    for method in METHODS:
        cells = []
        for period in PERIODS_US:
            own = found.get((method, period), Counter())
            points = sum(own[kind] for kind in OUTCOMES)
            wrong = points - own[RIGHT] - own["derated"] - own[REFUSED]
            cells.append(f"{wrong} of {points}" if points else "–")
        rows.append((f"`{method}`", *cells))
    return table(("not right", *(f"{period} µs" for period in PERIODS_US)), rows)


def sensors_table(results: Results) -> str:
    found = counts(results.outcomes, lambda one: one.sensors)
    return table(("sensors", *OUTCOMES), ((name, *_kinds(own)) for name, own in sorted(found.items())))


def causes_text(results: Results) -> str:
    found = causes(results.not_right)
    return ", ".join(f"{name} {count}" for name, count in found.most_common()) or "none"


def examples_table(results: Results) -> str:
    """Some of what is not right, of each scenario."""
    rows = [
        ("points", o.machine, f"`{o.method}`", o.period_us, f"{o.speed:g}, torque {o.torque:g}", f"{o.kind}: {o.why}")
        for o in scenarios.spread(results.not_right, SHOWN)
    ]
    for name in scenarios.NAMES:
        bad = scenarios.not_right(row for row in results.scenarios if row["scenario"] == name)
        rows += [
            (name, r["machine"], f"`{r['method']}`", r["period_us"], r["what"], f"{r['kind']}: {r['why']}")
            for r in scenarios.spread(bad, SHOWN)
        ]
    return (
        table(("scenario", "machine", "method", "µs", "speed", "what"), rows, left=(0, 1, 2, 4, 5)) if rows else "None."
    )


def refusals_text(results: Results) -> str:
    """Sentences that differ by their figures alone once, with the number of their points."""
    found: dict[str, list[str]] = {}
    for one in results.outcomes:
        if one.kind == REFUSED:
            sentence = one.why.removeprefix(f"{one.machine}: ")
            found.setdefault(re.sub(r"\d+(\.\d+)?", "…", sentence), []).append(sentence)
    groups = sorted(found.values(), key=len, reverse=True)[:SHOWN]
    return "\n".join(f"- {len(group)}: {group[0]}" for group in groups) or "None."


def _cell(found: Counter) -> str:
    return "/".join(
        str(count) for count in (found[RIGHT], found[DERATED], found[REFUSED], found[TRIPPED] + found[WRONG])
    )


def overview_table(results: Results) -> str:
    """Every scenario, by machine."""
    points = counts(results.outcomes, lambda one: one.machine)
    others = {
        name: scenarios.counts(row for row in results.scenarios if row["scenario"] == name) for name in scenarios.NAMES
    }
    rows: list[tuple] = []
    total = {name: Counter() for name in ("points", *others)}
    for machine in results.machines:
        own = {"points": points.get(machine["id"], Counter())}
        own |= {name: found.get(machine["id"], Counter()) for name, found in others.items()}
        for name, found in own.items():
            total[name] += found
        rows.append((machine["name"], *_size(machine), *map(_cell, own.values()), own["points"]["needless"]))
    rows.append(("**all**", "", "", "", *map(_cell, total.values()), total["points"]["needless"]))
    return table(("machine", "kW", "V", "poles", *total, "without need"), rows)


def scenario_table(results: Results, name: str) -> str:
    """Of a scenario, by machine."""
    found = scenarios.counts(row for row in results.scenarios if row["scenario"] == name)
    rows: list[tuple] = []
    for machine in results.machines:
        own = found.get(machine["id"], Counter())
        rows.append((machine["name"], own.total(), *_kinds(own)))
    total = sum(found.values(), Counter())
    rows.append(("**all**", total.total(), *_kinds(total)))
    return table(("machine", name, *OUTCOMES), rows)


def fields(results: Results) -> dict[str, str]:
    tripped = sum(one.kind == TRIPPED for one in results.outcomes)
    return {
        "version": f"{results.version}, {results.commit[:10]}",
        "command": results.command,
        "seed": str(results.seed),
        "points": str(len(results.outcomes)),
        "not_right": str(len(results.not_right)),
        "tripped": str(tripped),
        "causes": causes_text(results),
        "overview": overview_table(results),
        "examples": examples_table(results),
        "refusals": refusals_text(results),
    }


def text(results: Results) -> str:
    """What a terminal shows."""
    parts = []
    if results.outcomes:
        parts += [machines_table(results), methods_table(results), sensors_table(results)]
        parts.append(
            f"{len(results.not_right)} of {len(results.outcomes)} points are not right: {causes_text(results)}"
        )
    if results.faults:
        parts.append(injections_table(results.faults, ("fault", "method")))
    for name in dict.fromkeys(row["scenario"] for row in results.scenarios):
        parts.append(scenario_table(results, name))
    if results.scenarios:
        parts.append(examples_table(results))
    return "\n\n".join(parts)


def write(results: Results, directory: Path) -> list[Path]:
    """Picture and page; the files that are written."""
    picture = directory / "images" / "machine_library.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw(results, picture)
    page = directory / "machine_library.md"
    page.write_text(filled(TEMPLATE, fields(results)), encoding="utf-8")
    return [picture, page]
