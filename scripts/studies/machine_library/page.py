"""The page of the study over the library of machines, from its results."""

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from sextant_py.control_methods import METHODS

from studies import plant_faults as faults
from studies.page import filled, table

from . import scenarios
from .points import PERIODS_US
from .results import DERATED, OUTCOMES, REFUSED, RIGHT, TRIPPED, WRONG, Results, causes, counts

TEMPLATE = Path(__file__).with_name("page.md")
SHOWN = 20  # points that are listed


def machines_table(results: Results) -> str:
    head = ("machine", "kW", "V", "poles", *OUTCOMES, "derated without need")
    found = counts(results.outcomes, lambda one: one.machine)
    rows = []
    for machine in results.machines:
        own = found.get(machine["id"], Counter())
        size = (f"{machine['power_w'] / 1e3:.3g}", f"{machine['voltage']:.0f}", machine["poles"])
        rows.append((machine["name"], *size, *(own[kind] for kind in OUTCOMES), own["needless"]))
    total = counts(results.outcomes, lambda one: "all").get("all", Counter())
    rows.append(("**all**", "", "", "", *(total[kind] for kind in OUTCOMES), total["needless"]))
    return table(head, rows)


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
    return table(("sensors", *OUTCOMES), ((name, *(own[k] for k in OUTCOMES)) for name, own in sorted(found.items())))


def causes_text(results: Results) -> str:
    found = causes(results.not_right)
    return ", ".join(f"{name} {count}" for name, count in found.most_common()) or "none"


def _spread(bad: list) -> list:
    """Some of these, spread over all of them."""
    return [bad[n * len(bad) // min(SHOWN, len(bad))] for n in range(min(SHOWN, len(bad)))]


def examples_table(results: Results) -> str:
    """Some of what is not right, of each scenario."""
    rows = [
        ("points", o.machine, f"`{o.method}`", o.period_us, f"{o.speed:g}, torque {o.torque:g}", f"{o.kind}: {o.why}")
        for o in _spread(results.not_right)
    ]
    for name in scenarios.NAMES:
        rows += [
            (name, r["machine"], f"`{r['method']}`", r["period_us"], r["what"], f"{r['kind']}: {r['why']}")
            for r in _spread(scenarios.not_right(row for row in results.scenarios if row["scenario"] == name))
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


def overview_table(results: Results) -> str:
    """Every scenario, over all machines."""
    found = {"points": counts(results.outcomes, lambda one: "all").get("all", Counter())}
    for name in scenarios.NAMES:
        found[name] = Counter(row["kind"] for row in results.scenarios if row["scenario"] == name)
    rows = [
        (
            name,
            own[RIGHT],
            own[DERATED],
            own["needless"] if name == "points" else "–",
            own[REFUSED],
            own[TRIPPED] + own[WRONG],
        )
        for name, own in found.items()
    ]
    return table(("", "right", "derated", "of them without need", "refused", "not right"), rows)


def _seen(rows: Iterable[dict]) -> str:
    rows = list(rows)
    if not rows:
        return "–"
    parts = []
    for kind in faults.KINDS:
        own = [row for row in rows if row["kind"] == kind]
        if own:
            late = max((row["late_ms"] for row in own if row["late_ms"] is not None), default=None)
            parts.append(f"{kind} {len(own)}" + (f" (≤ {late:.3g} ms)" if late is not None else ""))
    return ", ".join(parts)


def _injected(results: Results) -> list[faults.PlantFault]:
    names = {row["fault"] for row in results.faults}
    return [fault for fault in faults.FAULTS if fault.name in names]


def faults_table(results: Results) -> str:
    names = [fault.name for fault in _injected(results)]
    rows = []
    for method in METHODS:
        own = [row for row in results.faults if row["method"] == method]
        if own:
            rows.append((f"`{method}`", *(_seen(row for row in own if row["fault"] == name) for name in names)))
    return table(("method", *names), rows, left=range(len(names) + 1))


def names_table(results: Results) -> str:
    """By which name the drive trips, of all methods together."""
    rows = []
    for fault in _injected(results):
        own = [row for row in results.faults if row["fault"] == fault.name]
        seen = Counter(row["seen"] for row in own if row["kind"] in (faults.NAMED, faults.OTHERWISE))
        missed = sum(row["kind"] == faults.MISSED for row in own)
        named = ", ".join(f"{name} {count}" for name, count in seen.most_common()) or "–"
        rows.append((fault.name, ", ".join(fault.names), len(own), missed, named))
    return table(("fault", "right name", "runs", "missed", "tripped as"), rows, left=(0, 1, 4))


def scenario_table(results: Results, name: str) -> str:
    """Of a scenario, by machine."""
    found = scenarios.counts(row for row in results.scenarios if row["scenario"] == name)
    rows: list[tuple] = []
    for machine in results.machines:
        own = found.get(machine["id"], Counter())
        rows.append((machine["name"], own.total(), *(own[kind] for kind in OUTCOMES)))
    total = sum(found.values(), Counter())
    rows.append(("**all**", total.total(), *(total[kind] for kind in OUTCOMES)))
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
        parts += [names_table(results), faults_table(results)]
    for name in dict.fromkeys(row["scenario"] for row in results.scenarios):
        parts.append(scenario_table(results, name))
    if results.scenarios:
        parts.append(examples_table(results))
    return "\n\n".join(parts)


def render(results: Results) -> str:
    return filled(TEMPLATE, fields(results))


def write(results: Results, directory: Path) -> list[Path]:
    """Picture and page; the files that are written."""
    from .figure import draw

    picture = directory / "images" / "machine_library.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw(results, picture)
    page = directory / "machine_library.md"
    page.write_text(render(results), encoding="utf-8")
    return [picture, page]
