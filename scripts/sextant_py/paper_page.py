"""docs/paper/README.md, made of its template and of the committed numbers alone."""

import math
import re
from collections.abc import Callable
from pathlib import Path

from .paper_cycle import FIGURES
from .paper_numbers import Numbers
from .paper_rise import SLOPES
from .paper_speed import LONG, SHORT
from .paper_steady import TORQUES
from .paper_steps import REVERSALS_S, STEPS
from .paper_vehicle import KINDS

TEMPLATE = Path(__file__).with_name("paper_page.md")
_NUMBER = re.compile(r"\{([\w/.]+):([^{}]+)\}")
_TABLE = re.compile(r"^<!-- table (\w+) -->$", re.MULTILINE)
_PART = re.compile(r"^<!-- if ([\w/.]+) -->\n(.*?)^<!-- end -->\n", re.MULTILINE | re.DOTALL)


def text(value: float, form: str) -> str:
    """`k1` is thousands with one decimal; everything else is Python's. A true minus, a dash for no number."""
    if not math.isfinite(value):
        return "–"
    if form.startswith("k"):
        value, form = value / 1e3, f".{form[1:]}f"
    return f"{value:{form}}".replace("-", "−")


def row(*cells: str) -> str:
    return "| " + " | ".join(cells) + " |"


def table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join([row(*head), row("---", *["---:"] * (len(head) - 1)), *(row(*cells) for cells in rows)])


def response_table(n: Numbers) -> str:
    def cell(name: str, form: str) -> str:
        return text(n[name], form) if name in n else ""

    rows = [
        [
            f"{step}",
            cell(f"response/centred/dead/{step}", ".2f"),
            cell(f"response/v1/dead/{step}", ".2f"),
            cell(f"response/centred/magnetised/{step}", ".3f"),
            cell(f"response/sampled/dead/{step}", ".2f"),
            cell(f"surge/centred/{step}", ".0f"),
            cell(f"surge/v1/{step}", ".0f"),
        ]
        for step in STEPS
    ]
    head = [
        "step [N·m]",
        "centred [ms]",
        "from V1 [ms]",
        "magnetised [ms]",
        "sampled [ms]",
        "surge, centred [A]",
        "surge, V1 [A]",
    ]
    return table(head, rows)


def reversal_table(n: Numbers) -> str:
    steps = dict(zip(REVERSALS_S, ("0 → 30", "30 → −30", "−30 → 15", "15 → −15", "−15 → 30"), strict=True))
    rows = [[f"{t_s:g}", what, text(n[f"3_2/response_ms/{t_s}"], ".3f")] for t_s, what in steps.items()]
    return table(["at [s]", "step [N·m]", "95 % after [ms]"], rows)


def dead_zone_table(n: Numbers) -> str:
    rows = [
        [
            f"{s:g}",
            text(918 / s, ".2f"),
            text(n[f"dead_zone/ramp/begins/{s}"], ".2f"),
            text(n[f"dead_zone/ramp/meets/{s}"], ".2f"),
        ]
        for s in SLOPES
    ]
    return table(["slope [N·m/s]", "HB / slope [ms]", "torque begins [ms]", "meets its reference [ms]"], rows)


def limit_table(n: Numbers) -> str:
    rows = [
        [f"{t}", text(n[f"limit_speed/{t}"], ".0f"), text(n[f"limit_speed_calculated/{t}"], ".0f")] for t in TORQUES
    ]
    return table(["torque [N·m]", "measured [rad/s]", "calculated [rad/s]"], rows)


def frequency_table(n: Numbers) -> str:
    rows = []
    for speed in (5, 10, 20, 30, 50, 70, 90, 110, 120, 130):
        half, middle, full = (n[f"pulse/15/{b}/{speed}"] for b in ("0.5", "0.918", "1"))
        line = full + (half - full) * 0.164
        legs = n[f"leg/15/0.918/{speed}"]
        rows.append([f"{speed}", *(text(x, "k1") for x in (half, middle, full, line, legs))])
    head = [
        "speed [rad/s]",
        "HB 0.5 [kHz]",
        "HB 0.918 [kHz]",
        "HB 1 [kHz]",
        "paper's line at 0.918 [kHz]",
        "one leg, HB 0.918 [kHz]",
    ]
    return table(head, rows)


def table6(n: Numbers) -> str:
    rows = []
    for (upper, lower), figure in sorted(FIGURES.items(), key=lambda item: item[1]):
        name = f"table6/{upper}/{lower}/"

        def cell(key: str, form: str, name: str = name) -> str:
            return text(n[name + key], form)

        rows.append(
            [
                f"{figure}",
                f"{upper:g}",
                f"{lower:g}",
                cell("drive_low_nm", ".2f") + " … " + cell("drive_high_nm", "+.2f"),
                cell("drive_bias_nm", ".2f"),
                cell("rest_low_nm", ".2f") + " … " + cell("rest_high_nm", "+.2f"),
                cell("rest_bias_nm", "+.2f"),
                cell("leg_hz", "k2"),
                cell("pulse_hz", "k1"),
                cell("first_dead_s", ".2f"),
                cell("first_error_nm", ".2f"),
                cell("first_a", ".0f"),
            ]
        )
    head = ["Figure", "upper", "lower", "driving: error [N·m]", "bias", "at rest: error [N·m]", "bias"]
    head += ["leg [kHz]", "comparator [kHz]", "no torque for [s]", "worst error [N·m]", "surge [A]"]
    return table(head, rows)


def cycle_table(n: Numbers) -> str:
    lines = (
        ("torque error, RMS [N·m]", "torque_error_rms_nm", ".3f"),
        ("torque error, worst after 0.2 s [N·m]", "torque_error_max_nm", ".2f"),
        ("torque leaves its band, times", "distortions", ".0f"),
        ("… by at most [N·m]", "distortions_worst_nm", ".2f"),
        ("… for at most [ms]", "distortions_longest_ms", ".0f"),
        ("current above 25 A after the start, times", "surges", ".0f"),
        ("largest current vector after 0.2 s [A]", "surge_worst_a", ".0f"),
        ("time with the flux below 95 % [%]", "flux_low_percent", ".0f"),
        ("least flux after 0.2 s [Wb]", "flux_min_wb", ".3f"),
        ("torque reference below zero [% of the time]", "negative_percent", ".0f"),
        ("pulses of the comparator [kHz]", "torque_pulse_frequency_hz", "k1"),
        ("switching of a leg [kHz]", "switching_frequency_hz", "k1"),
        ("drawn from the link, see below [kJ]", "energy_from_link_j", "k1"),
        ("fed back into the link, see below [kJ]", "energy_to_link_j", "k1"),
        ("drawn less fed back [kJ]", "net_j", "k1"),
        ("work on the shaft [kJ]", "energy_shaft_j", "k1"),
        ("lost in the windings [kJ]", "energy_copper_j", "k1"),
    )
    kinds = ("linear", "clip", "origin", "sampled")
    rows = [
        [what, *(text(n[f"nycc/{k}/{key}"], form) if f"nycc/{k}/{key}" in n else "" for k in kinds)]
        for what, key, form in lines
    ]
    return table(["NYCC, 598 s", "linear", "clip", "origin", "linear, sampled"], rows)


def road_load_table(n: Numbers) -> str:
    columns = (("speed_kmh", ".0f"), ("torque_nm", ".0f"), ("fit_nm", ".2f"), ("residual_nm", "+.2f"))
    states = [name.removesuffix("/speed_kmh") for name in n.under("vehicle/fit/") if name.endswith("/speed_kmh")]
    rows = [[text(n[f"vehicle/fit/{state}/{key}"], form) for key, form in columns] for state in states]
    return table(["vehicle speed [km/h]", "Table 5 [N·m]", "fit [N·m]", "residual, table − fit [N·m]"], rows)


def vehicle_table(n: Numbers) -> str:
    lines = (
        ("speed error, RMS [rad/s]", "speed_error_rms_rad_s", ".3f"),
        ("… at the wheel [m/s]", "speed_error_rms_m_s", ".4f"),
        ("speed error, worst [km/h]", "speed_error_max_kmh", ".2f"),
        ("torque error, RMS [N·m]", "torque_error_rms_nm", ".2f"),
        ("torque error, worst [N·m]", "torque_error_max_nm", ".1f"),
        ("largest phase current [A]", "peak_current_a", ".0f"),
        ("time with the flux below 95 % [%]", "flux_low_percent", ".0f"),
        ("drawn from the link ¹ [kJ]", "energy_from_link_j", "k1"),
        ("fed back into the link ¹ [kJ]", "energy_to_link_j", "k1"),
        ("drawn, in means of 10 ms [kJ]", "from_10_ms_j", "k1"),
        ("fed back, in means of 10 ms [kJ]", "to_10_ms_j", "k1"),
        ("drawn less fed back [kJ]", "net_j", "k1"),
        ("net work on the shaft [kJ]", "energy_shaft_j", "k1"),
        ("lost in the windings [kJ]", "energy_copper_j", "k1"),
        ("efficiency of motor and inverter, shaft / (drawn − fed back) [%]", "efficiency_percent", ".1f"),
        ("taken from the shaft by braking [kJ]", "braking_j", "k1"),
        ("… of which reaches the link while power flows back [%]", "recovered_percent", ".0f"),
        ("… on balance over all the braking [%]", "recovered_net_percent", ".0f"),
    )
    rows = [[what, *(text(n[f"vehicle/{kind}/{key}"], form) for kind in KINDS)] for what, key, form in lines]
    return table(["NYCC with vehicle and driver, one motor of two", "event-exact", "sampled 25 µs"], rows)


def speed_table(n: Numbers) -> str:
    def cell(engine: str, scenario: str) -> str:
        name = f"realtime/{engine}/{scenario}"
        return text(n[name], ".3g") if name in n else ""

    rows = [[s, *(cell(engine, s) for engine in ("cvode", "fixed", "sampled"))] for s in (*SHORT, *LONG)]
    return table(["scenario", "event-exact, CVODE 1e-8", "event-exact, fixed step", "sampled 25 µs, fixed step"], rows)


TABLES: dict[str, Callable[[Numbers], str]] = {
    "response": response_table,
    "reversal": reversal_table,
    "dead_zone": dead_zone_table,
    "limit": limit_table,
    "frequency": frequency_table,
    "table6": table6,
    "cycle": cycle_table,
    "road_load": road_load_table,
    "vehicle": vehicle_table,
    "speed": speed_table,
}


def render(numbers: Numbers, template: str | None = None) -> str:
    """The page. A number that it names and that is not there is an error: KeyError."""
    page = TEMPLATE.read_text(encoding="utf-8") if template is None else template
    page = _PART.sub(lambda part: part[2] if numbers.under(part[1]) else "", page)
    page = _TABLE.sub(lambda name: TABLES[name[1]](numbers), page)
    return _NUMBER.sub(lambda number: text(numbers[number[1]], number[2]), page)
