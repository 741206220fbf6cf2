"""The page of the torque map, from its results."""

from pathlib import Path

from studies.page import filled, table

from . import figures, kinds
from .capability import worst_difference
from .drive import GUARANTEED
from .points import L_M, R_R, R_S
from .results import MEANING, RIGHT, SILENT, UNOBSERVABLE_RAD_S, UNSEEN, MapOf, Results, beyond_r_s, trips
from .scale import SPEEDS, TORQUES

Maps = dict[str, Results]

TEMPLATE = Path(__file__).with_name("page.md")


def _numbers(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def counts_table(maps: Maps) -> str:
    head = ("points", *(results.label for results in maps.values()))
    rows = [("all", *(results.points for results in maps.values()))]
    for letter, meaning in MEANING.items():
        counts = [results.counts[letter] for results in maps.values()]
        if any(counts) or letter in (RIGHT, SILENT, UNSEEN):
            rows.append((f"**{meaning}**" if letter == SILENT else meaning, *counts))
    return table(head, rows)


def faults_table(maps: Maps) -> str:
    found = [trips(results.maps) for results in maps.values()]
    names = sorted({name for one in found for name in one}, key=lambda name: -sum(one[name] for one in found))
    return table(
        ("first fault", *(results.label for results in maps.values())), ((n, *(one[n] for one in found)) for n in names)
    )


def worst(results: Results) -> str:
    """The longest silent point, with what reproduces it."""
    longest: tuple[float, MapOf, str] | None = None
    for one in results.maps:
        for where, silent_ms in one.silent_ms.items():
            row, column = _place(results, where)
            if one.outcomes[row][column] == SILENT and (longest is None or silent_ms > longest[0]):
                longest = (silent_ms, one, where)
    if longest is None:
        return f"{results.label}: no point is silently wrong."
    silent_ms, one, where = longest
    speed, torque = where.split("/")
    place = f"{speed} rad/s and {torque} N·m with {one.conditions.label}"
    return f"{results.label}: the longest silence is {silent_ms:g} ms, at {place}."


def _place(results: Results, where: str) -> tuple[int, int]:
    speed, torque = map(float, where.split("/"))
    return results.torques.index(torque), results.speeds.index(speed)


def resistance_table(maps: Maps) -> str:
    """Points with exact parameters but for the stator resistance."""
    rows = []
    for results in maps.values():
        sets = [one for one in results.maps if one.conditions.is_r_s_alone]
        beyond = beyond_r_s(results)
        text = "–"
        if beyond:
            conditions, speed, torque, deviation = max(beyond, key=lambda one: one[3])
            text = f"{deviation:g} N·m at {speed:g} rad/s and {torque:g} N·m with {conditions.label}"
        count = sum(sum(one.counts.values()) for one in sets)
        rows.append((results.label, count, len(beyond), sum(trips(sets).values()), text))
    return table(("drive", "points", "off", "trips", "worst"), rows, left=(0, 4))


def capability_sentence(maps: Maps) -> str:
    """The worst of all drives."""
    found = [(*worst_difference(results.capability), results.label) for results in maps.values()]
    percent, speed, direction, label = max(found, key=lambda one: abs(one[0]))
    return f"At worst {percent:+.1f} %: {label}, {direction} at {speed:g} rad/s."


def fields(maps: Maps) -> dict[str, str]:
    """What the template names."""
    guaranteed, all_maps = maps[GUARANTEED], maps.values()
    left_out = "".join(
        f"\n\nNot set for {r.label}, whose version has no such keys: {', '.join(f'`{key}`' for key in r.left_out)}."
        for r in all_maps
        if r.left_out
    )
    return {
        "files": ", ".join(f"`{name}.json`" for name in maps),
        "versions": "; ".join(f"{r.label}: {r.version}, {r.commit[:10]}" for r in all_maps),
        "speeds": _numbers(SPEEDS[len(SPEEDS) // 2 :]),
        "torques": _numbers(TORQUES[len(TORQUES) // 2 :]),
        "r_s": _numbers(R_S),
        "r_r": _numbers(R_R),
        "l_m": _numbers(L_M),
        "sets": f"{len(guaranteed.maps)}",
        "counts": counts_table(maps),
        "worst": worst(guaranteed),
        "kinds": kinds.kinds_table(maps[name] for name in maps if name != "paper"),
        "unobservable": f"{UNOBSERVABLE_RAD_S:g}",
        "left_out": left_out,
        "resistance": resistance_table(maps),
        "faults": faults_table(maps),
        "capability": capability_sentence(maps),
    }


def write(maps: Maps, directory: Path) -> list[Path]:
    """Pictures and page; the files that are written."""
    written = []
    for name, draw in figures.PICTURES.items():
        draw(maps, directory / f"{name}.png")
        written.append(directory / f"{name}.png")
    page = directory / "README.md"
    page.write_text(filled(TEMPLATE, fields(maps)), encoding="utf-8")
    return [*written, page]
