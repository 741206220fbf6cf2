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
from .results import OUTCOMES, REFUSED, TRIPPED, Results, causes, grouped

TEMPLATE = Path(__file__).with_name("page.md")
SHOWN = 20  # points that are listed
POINTS, NEEDLESS = "points", "without need"


def kinds_by_machine(results: Results) -> dict[str, Counter]:
    """How many points and runs ended how: of each machine by scenario and kind; and the points derated without need."""
    found = {machine["id"]: Counter() for machine in results.machines}
    for one in results.outcomes:
        found[one.machine].update({(POINTS, one.kind): 1, (POINTS, NEEDLESS): int(one.is_needless)})
    for row in results.scenarios:
        found[row["machine"]][row["scenario"], row["kind"]] += 1
    return found


def scenario_table(results: Results, name: str) -> str:
    """Of a scenario, or of the points, by machine."""
    kinds = (*OUTCOMES, NEEDLESS) if name == POINTS else OUTCOMES
    found, rows = kinds_by_machine(results), []
    for m in results.machines:
        size = (f"{m['power_w'] / 1e3:.3g}", f"{m['voltage']:.0f}", m["poles"])
        rows.append((m["name"], *size, *(found[m["id"]][name, kind] for kind in kinds)))
    total = sum(found.values(), Counter())
    rows.append(("**all**", "", "", "", *(total[name, kind] for kind in kinds)))
    return table(("machine", "kW", "V", "poles", *kinds), rows)


def overview_table(results: Results) -> str:
    """Every scenario, over all machines."""
    found, rows = sum(kinds_by_machine(results).values(), Counter()), []
    for name in (POINTS, *scenarios.NAMES):
        right, derated, refused, tripped, wrong = (found[name, kind] for kind in OUTCOMES)
        needless = found[name, NEEDLESS] if name == POINTS else "–"
        rows.append((name, right, derated, needless, refused, tripped + wrong))
    return table(("", "right", "derated", "of them without need", "refused", "not right"), rows)


def methods_table(results: Results) -> str:
    """Points that are not right, of all, by method and period."""
    found = grouped(results.outcomes, lambda one: (one.method, one.period_us))

    def cell(method: str, period: int) -> str:
        own = found.get((method, period), [])
        return f"{sum(not one.is_right for one in own)} of {len(own)}" if own else "–"

    rows = ((f"`{method}`", *(cell(method, period) for period in PERIODS_US)) for method in METHODS)
    return table(("not right", *(f"{period} µs" for period in PERIODS_US)), rows)


def sensors_table(results: Results) -> str:
    found = grouped(results.outcomes, lambda one: one.sensors)
    kinds = {name: Counter(one.kind for one in own) for name, own in sorted(found.items())}
    return table(("sensors", *OUTCOMES), ((name, *(own[kind] for kind in OUTCOMES)) for name, own in kinds.items()))


def causes_text(results: Results) -> str:
    found = causes(results.not_right)
    return ", ".join(f"{name} {count}" for name, count in found.most_common()) or "none"


def examples_table(results: Results) -> str:
    """Some of what is not right, of each scenario."""
    rows = [
        (POINTS, o.machine, f"`{o.method}`", o.period_us, f"{o.speed:g}, torque {o.torque:g}", f"{o.kind}: {o.why}")
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
        parts += [scenario_table(results, POINTS), methods_table(results), sensors_table(results)]
        parts.append(
            f"{len(results.not_right)} of {len(results.outcomes)} points are not right: {causes_text(results)}"
        )
    if results.faults:
        parts.append(injections_table(results.faults, ("fault", "method")))
    for name in dict.fromkeys(row["scenario"] for row in results.scenarios):
        parts.append(f"{name}:\n\n{scenario_table(results, name)}")
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
