"""The work-precision diagram of the plant integrators and the table beside it."""

import argparse
import json
import math
import subprocess
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes
from sextant_py import errors
from sextant_py.paths import ROOT

from studies import json_file, page
from studies.origin import Origin
from studies.picture import picture

from . import closed_loops

DATA = Path(__file__).with_name("results.json")
PICTURE = ROOT / "docs" / "images" / "work_precision.png"
PAGE = ROOT / "docs" / "performance_plant.md"
MARK = "table: scripts/work_precision"
LOOPS_MARK = "closed loops: scripts/work_precision"
ORIGIN_MARK = "run: scripts/work_precision"
PROGRAM = ROOT / "build" / "release" / "tests" / "bench" / "sextant_work_precision"
CONTRACT_NM = 1e-6
SERIES = {
    "fixed": ("fixed", "#1b4f9c", "o"),
    "exact": ("exact", "#3f8f5b", "s"),
    "erk": ("erk", "#7a3b9a", "D"),
    "cvode": ("cvode, Adams", "#b3282d", "^"),
    "cvode_bdf": ("cvode, BDF", "#e08e2b", "v"),
}
SHAFTS = {"free_shaft": "Shaft follows the torques", "constant_speed": "Constant speed"}
# Where the labels of a series stand, in points from their marks.
OFFSETS = {"fixed": (7, -4, "left"), "exact": (7, 3, "left"), "erk": (7, 3, "left")}
CLOSE = 0.1  # decades
BESIDE = {"cvode": (-6, -10, "right"), "cvode_bdf": (7, 2, "left")}


@dataclass
class Measurement:
    """What the program prints, and where it ran."""

    origin: Origin
    closed_loops: list
    constant_speed: dict
    free_shaft: dict
    period_us: float
    simulated_s: float
    voltage_changes: int


def points_of(panel: dict, integrator: str) -> list[dict]:
    """In order of their error; a default that repeats a setting is left out."""
    found = [p for p in panel["points"] if p["integrator"] == integrator]
    if integrator == "cvode":
        found = [p for p in found if not p["default"]]
    return sorted(found, key=lambda p: p["cpu_s_per_simulated_s"])


def label(point: dict) -> str:
    return point["setting"].removeprefix("default, ").replace(" us", " µs").replace("1e-0", "1e-")


def close_points(points: list[dict]) -> list[list[dict]]:
    """Neighbours whose labels would stand on each other, together."""

    def apart(one: dict, other: dict) -> float:
        return max(abs(math.log10(one[key] / other[key])) for key in ("torque_error_nm", "cpu_s_per_simulated_s"))

    groups: list[list[dict]] = []
    for point in points:
        if groups and apart(groups[-1][-1], point) < CLOSE:
            groups[-1].append(point)
        else:
            groups.append([point])
    return groups


def draw_series(axes: Axes, panel: dict, integrator: str) -> None:
    name, colour, marker = SERIES[integrator]
    points = points_of(panel, integrator)
    x = [p["torque_error_nm"] for p in points]
    y = [p["cpu_s_per_simulated_s"] for p in points]
    axes.loglog(x, y, color=colour, marker=marker, markersize=5.5, linewidth=1.2, label=name)
    dx, dy, side = (OFFSETS | BESIDE)[integrator]
    written = {"erk": points, "fixed": points[:1], "exact": points[:1]}.get(integrator, points)
    for group in close_points(written):
        position = (group[0]["torque_error_nm"], group[0]["cpu_s_per_simulated_s"])
        text = ", ".join(label(point) for point in group)
        axes.annotate(text, position, (dx, dy), textcoords="offset points", ha=side, fontsize=7.5, color=colour)


def draw(data: Measurement, file: Path) -> None:
    with picture(file, 1, 2, (9.2, 4.6), sharex=True, sharey=True) as (_, (panels,)):
        for axes, (key, title) in zip(panels, SHAFTS.items(), strict=True):
            for integrator in SERIES:
                draw_series(axes, getattr(data, key), integrator)
            axes.axvline(CONTRACT_NM, color="#777777", linewidth=0.8, linestyle="--")
            axes.set_title(title)
            axes.set_xlabel("largest error of the torque over the run [N·m]")
        panels[0].set_xlim(2e-12, 3.0)
        panels[0].set_ylabel("processor time per simulated second [s/s]")
        panels[0].text(
            CONTRACT_NM * 1.3, panels[0].get_ylim()[0] * 1.15, "bound: 1e-6 N·m", fontsize=7.5, color="#555555"
        )
        panels[1].legend(loc="lower right", fontsize=9)


def table(data: Measurement) -> str:
    """The integrators as they come, without any setting."""
    head = ("`plant.integrator`", "torque error [N·m]", "at constant speed [N·m]", "times real time")
    held = {p["integrator"]: p for p in data.constant_speed["points"] if p["default"]}
    rows = []
    for point in data.free_shaft["points"]:
        if point["default"]:
            name, period = point["integrator"], point["period_us"]
            errors_nm = (f"{one['torque_error_nm']:.1e}" for one in (point, held[name]))
            times = (f"{period[key]:.2f}" for key in ("median", "p99_9", "max_of_least_of_9"))
            rows.append((f"`{name}`", *errors_nm, f"{1 / point['cpu_s_per_simulated_s']:.0f}", ", ".join(times)))
    return page.table((*head, "a period: median, 99.9 %, worst [µs]"), rows)


def rounded(value: object) -> object:
    """Four digits are enough to publish."""
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    return [rounded(item) for item in value] if isinstance(value, list) else value


def measure() -> Measurement:
    origin = Origin.now()
    done = subprocess.run([PROGRAM], capture_output=True, text=True)
    if done.returncode != 0:
        raise errors.UserError(f"{PROGRAM.name} failed: {done.stderr.strip()}")
    return Measurement(origin, **rounded(json.loads(done.stdout)))


def load(source: Path) -> Measurement:
    data = json_file.read(source, Measurement, "work_precision")
    if not (data.constant_speed and data.free_shaft and data.closed_loops):
        raise errors.UserError(f"{source} holds no points or no closed loops.")
    return data


def write_page(data: Measurement) -> None:
    loops = closed_loops.table(data.closed_loops)
    blocks = {ORIGIN_MARK: data.origin.text, MARK: table(data), LOOPS_MARK: loops}
    print("\n\n".join(blocks.values()), end="\n\n")
    page.put_into(PAGE, blocks)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="work_precision", description="Writes work and precision of the integrators.")
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE", help="an earlier measurement, drawn again")
    source = parser.parse_args(arguments).file
    data = load(source) if source else measure()
    json_file.write(DATA, data)
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    draw(data, PICTURE)
    write_page(data)
    print(f"written: {PICTURE.relative_to(ROOT)}, {DATA.relative_to(ROOT)}, {PAGE.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    errors.run("work_precision", main)
