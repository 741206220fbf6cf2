"""The page of the comparison with motulator, from its results."""

import math
from pathlib import Path

from studies.page import figure, filled, table

from . import figures
from .cases import BANDWIDTH_RAD_S, SHOWN
from .measure import LIMIT_PERCENT, QUANTITIES, Record, Results

TEMPLATE = Path(__file__).with_name("page.md")
UNITS = {
    "torque_nm": ("mean torque [N·m]", 3),
    "current_a": ("stator current [A]", 3),
    "flux_wb": ("stator flux [Wb]", 4),
    "stator_rad_s": ("stator frequency [rad/s]", 3),
    "slip_rad_s": ("slip frequency [rad/s]", 3),
    "power_w": ("active power [W]", 1),
}


# How a version is set and works, by the beginning of its number; the last one counts for all others.
OF_VERSION = {
    "0.5.": {"flux_setting": "`nom_psi_R`", "observer": "Euler's forward step"},
    "": {
        "flux_setting": "`psi_s_nom`, the stator flux without load at that rotor flux",
        "observer": "the discrete model of a voltage that is held for the period",
    },
}


def _of_version(version: str) -> dict[str, str]:
    return next(words for beginning, words in OF_VERSION.items() if version.startswith(beginning))


def _of(record: Record) -> tuple[str, str, str]:
    return f"{record.period_us:g}", f"{record.speed_rad_s:g}", f"{record.torque_nm:g}"


POINT = ("period [µs]", "speed [rad/s]", "torque [N·m]")


def _differences(results: Results) -> str:
    rows = []
    for record in results.records:
        cells = []
        for quantity in QUANTITIES:
            value = record.difference(quantity)
            cells.append(f"**{value:+.2f}**" if abs(value) > LIMIT_PERCENT else f"{value:+.2f}")
        rows.append((*_of(record), *cells))
    return table((*POINT, *QUANTITIES.values()), rows, left=())


def _largest(results: Results) -> str:
    """Of each quantity, over the points of each period."""
    rows = []
    for period in results.periods_us:
        records = results.at(period)
        worst = (max(abs(record.difference(quantity)) for record in records) for quantity in QUANTITIES)
        rows.append((f"{period:g}", len(records), *(f"{value:.2f}" for value in worst)))
    return table(("period [µs]", "points", *QUANTITIES.values()), rows, left=())


def _values(results: Results) -> str:
    """At the point SHOWN, by quantity and period."""
    records = [record for record in results.records if record.point == SHOWN]
    rows = []
    for quantity, (title, digits) in UNITS.items():
        equations = f"{records[0].equations[quantity]:.{digits}f}" if records else "–"
        drives = (getattr(record, drive)[quantity] for record in records for drive in ("sextant", "motulator"))
        rows.append((title, equations, *(f"{value:.{digits}f}" for value in drives)))
    periods = (f"{drive}, {record.period_us:g} µs" for record in records for drive in ("Sextant", "motulator"))
    return table(("", "equations", *periods), rows)


def _dynamics(results: Results, every: bool) -> str:
    """Of every point, or of the point SHOWN alone."""
    rows = []
    for record in results.records:
        if not every and record.point != SHOWN:
            continue
        cells = []
        for name, digits in (("rise_ms", 2), ("overshoot_percent", 1), ("ripple_rms_nm", 2), ("ripple_pp_nm", 2)):
            cells.append(" / ".join(figure(getattr(record, drive)[name], digits) for drive in ("sextant", "motulator")))
        rows.append((*(_of(record) if every else _of(record)[:1]), *cells))
    head = ("95 % of the step after [ms]", "overshoot [%]", "ripple, RMS [N·m]", "ripple, peak to peak [N·m]")
    return table((*(POINT if every else POINT[:1]), *head), rows, left=())


def _apart(results: Results) -> str:
    apart = results.apart()
    if not apart:
        return f"Every difference is within {LIMIT_PERCENT:g} %."
    names = "; ".join(f"{QUANTITIES[quantity]} at {record.name}" for record, quantity in apart)
    total = len(results.records) * len(QUANTITIES)
    return f"{total - len(apart)} of {total} differences are within {LIMIT_PERCENT:g} %. Not within: {names}."


def text(results: Results) -> str:
    """For the terminal: every point."""
    shown = {
        "largest": _largest(results),
        "differences": _differences(results),
        "values": _values(results),
        "dynamics": _dynamics(results, every=True),
    }
    return "\n\n".join(f"{name}\n{one}" for name, one in shown.items())


def write(results: Results, docs: Path) -> list[Path]:
    picture = figures.draw(results, docs / "images" / "motulator_step.png")
    plant = results.plant
    content = filled(
        TEMPLATE,
        dict(
            version=results.version,
            commit=results.commit,
            motulator=results.motulator_version,
            u_dc=f"{plant['u_dc_v']:g}",
            flux=f"{plant['flux_wb']:g}",
            limit=f"{LIMIT_PERCENT:g}",
            bandwidth=f"2π·{BANDWIDTH_RAD_S / (2 * math.pi):g}",
            speed=SHOWN[0],
            torque=SHOWN[1],
            apart=_apart(results),
            **_of_version(results.motulator_version),
            largest=_largest(results),
            dynamics=_dynamics(results, every=False),
        ),
    )
    page = docs / "motulator.md"
    page.write_text(content, encoding="utf-8")
    return [picture, page]
