"""Measures the drive of the paper's machine on a plant whose inverter has dead time, drops or a minimum pulse, told of
it or not, whose machine saturates or whose DC link has a capacitance.
"""

import argparse
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from sextant_py import identify, mil_program
from sextant_py.errors import UserError, run
from sextant_py.identify_files import told_dead_time_us, told_voltage_error_v
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, parser_of
from sextant_py.short_run import run_of
from sextant_py.sweep_file import Settings

from studies import honest_drive, identification, json_file, page
from studies.command import made, words
from studies.published import mean_and_due, published
from studies.torque_map.scale import SENSORS

EXAMPLES = """examples:
  scripts/inverter_study                                every case, with dtc and foc: some 2700 runs
  scripts/inverter_study --methods foc --cases 25       one method, the cases at 25 us
  scripts/inverter_study --drops                        the cases with drops of switches and diodes in their place
  scripts/inverter_study --pulses                       gate drivers with a minimum pulse in their place
  scripts/inverter_study --saturation                   a machine that saturates at the flux reference
  scripts/inverter_study --iron                         a machine with iron loss
  scripts/inverter_study --link                         a DC link with capacitance behind a resistance
  scripts/inverter_study --everything                   dead time, drops, saturation and real sensors at once
  scripts/inverter_study --speeds 0,5,50 --torques 60,-60
  scripts/inverter_study --identified --methods foc     told what scripts/identify finds on each plant

A point is right, derated (less torque, and the drive says so), tripped, or wrong, silently: the mean torque over 0.3 s
is off by more than 5 N·m and 5 % of the command. The largest error is that of the points that are right or derated. The
current before any command is the largest of runs without one."""
SPEEDS = tuple(s for v in (0, 2, 5, 10, 20, 50, 100, 200, 300, 400) for s in ((v, -v) if v else (0,)))  # [rad/s]
TORQUES = tuple(s for v in (10, 40, 90, 130) for s in (v, -v))  # [N·m]
METHODS = ("dtc", "foc")
STEP_S, FROM_S, END_S = 0.6, 1.1, 1.4
TOLERANCE_NM, TOLERANCE_SHARE = 5.0, 0.05
DERATED_SHARE = 0.97  # of the command, below which published torque is derating
TIME_LIMIT_S = 300  # of one run [s]
RIGHT, DERATED, TRIPPED, WRONG = "right", "derated", "tripped", "wrong"
KINDS = (RIGHT, DERATED, TRIPPED, WRONG)
THRESHOLD_V, SLOPE_OHM = 1.2, 0.02  # of switches and diodes where they have drops
# Of a machine whose inductance at the flux reference is half of what it is at small fluxes.
SATURATION = {"plant.saturation.knee_wb": 1.1, "plant.saturation.machine_flux_wb": 1.1, "plant.integrator": "fixed"}
# Iron loss at the flux reference and 50 Hz, half of it by hysteresis: 5 % of the rated 2.2 kW, by the square of a flux
# that is 2.12 times the rated one; and 5 % of 100 N·m.
IRON_LOSSES_W, IRON_AT_RAD_S = (497.0, 785.0), 314.159
LINK = {"plant.link.capacitance_f": 1e-3, "plant.link.source_ohm": 0.2, "plant.integrator": "fixed"}
SLOW = 20.0  # up to here a point counts as near standstill [rad/s]


def drops(end: str) -> Settings:
    """The drops of switches and diodes, of the plant or as the drive is told of them."""
    return {f"{end}.inverter.threshold_v": THRESHOLD_V, f"{end}.inverter.slope_ohm": SLOPE_OHM}


def pulses(period_us: int, shortest_us: float, short: str, told: bool) -> Settings:
    """Gate drivers that drop or stretch pulses below a minimum."""
    ends = ("plant", "drive") if told else ("plant",)
    own = {f"{end}.inverter.minimum_pulse_us": shortest_us for end in ends}
    return {"drive.period_us": period_us} | own | {f"{end}.inverter.short_pulses": short for end in ends}


def iron(loss_w: float) -> Settings:
    """Iron loss of the plant: P_fe = 3/2 (omega psi_R)²/R_fe, with psi_R = (1 − sigma) psi_s as without torque."""
    l_s, l_m = (0.754 + 26.13) / IRON_AT_RAD_S, 26.13 / IRON_AT_RAD_S
    voltage = IRON_AT_RAD_S * 1.1 * (l_m / l_s) ** 2
    each = round(1.5 * voltage**2 / (loss_w / 2), 1)
    resistances = {"plant.iron_loss.eddy_ohm": each, "plant.iron_loss.hysteresis_ohm": each}
    return resistances | {"plant.iron_loss.at_rad_s": IRON_AT_RAD_S, "plant.integrator": "fixed"}


def told_iron(loss_w: float) -> Settings:
    """The same as the drive is told of it, P_fe = 3/2 (omega psi_s)²/R_fe: right at that frequency without torque."""
    return {"drive.iron_loss_resistance_ohm": round(1.5 * (IRON_AT_RAD_S * 1.1) ** 2 / loss_w, 1)}


@dataclass(frozen=True)
class Case:
    """A plant, and what the drive is told of it."""

    period_us: int
    dead_us: float
    told_us: float
    everything: bool = False  # drops, saturation and real sensors too
    error_v: float | None = None  # of the voltage, as identified along with told_us
    r_s_ohm: float | None = None  # the same

    @property
    def name(self) -> str:
        plant = f"{self.period_us} us, {'everything on, ' if self.everything else ''}dead time {self.dead_us:g} us"
        if self.error_v is not None:
            return f"{plant}, identified"
        return plant + ("" if not self.dead_us else f", told {self.told_us:g} us" if self.told_us else ", not told")

    @property
    def plant(self) -> Settings:
        own = {"drive.period_us": self.period_us, "plant.inverter.dead_time_us": self.dead_us}
        return own | (honest_drive.plant_settings() if self.everything else {})

    @property
    def settings(self) -> Settings:
        told = {"drive.inverter.dead_time_us": self.told_us}
        if self.error_v is not None:
            told["drive.inverter.voltage_error_v"] = self.error_v
            told["control.machine_estimate.r_s_ohm"] = self.r_s_ohm
        elif self.everything:
            told |= drops("drive")
        return self.plant | told


@dataclass(frozen=True)
class NamedCase:
    """A plant that differs in something else than a dead time."""

    name: str
    settings: Settings


CASES = tuple(
    Case(period, dead, round(share * dead, 3))
    for period, dead in ((25, 0.0), (25, 1.5), (125, 0.0), (125, 3.0))
    for share in ((0, 1, 1.1, 0.9) if dead else (0,))
)  # fmt: skip
EVERYTHING_CASES = tuple(
    Case(one.period_us, one.dead_us, round(share * one.dead_us, 3), everything=True)
    for one in honest_drive.INVERTERS
    for share in (1, 1.1, 0.9)
)
DROPS = f"25 us, drops of {THRESHOLD_V:g} V + {SLOPE_OHM * 1e3:g} mOhm"
DROPS_CASES = (
    NamedCase(f"{DROPS}, not told", {"drive.period_us": 25} | drops("plant")),
    NamedCase(f"{DROPS}, told", {"drive.period_us": 25} | drops("plant") | drops("drive")),
)
PULSES_CASES = tuple(
    NamedCase(
        f"{period} us, pulses below {shortest:g} us {short}, {'told' if told else 'not told'}",
        pulses(period, shortest, short, told),
    )
    for period, shortest in ((25, 1.0), (125, 2.0))
    for short in ("dropped", "stretched")
    for told in (False, True)
)
IRON_CASES = tuple(
    NamedCase(
        f"25 us, iron loss of {loss:g} W at 50 Hz, {'told' if told else 'not told'}",
        {"drive.period_us": 25} | iron(loss) | (told_iron(loss) if told else {}),
    )
    for loss in IRON_LOSSES_W
    for told in (False, True)
)
SATURATION_CASES = (
    NamedCase("25 us, saturation, L_m right", {"drive.period_us": 25} | SATURATION),
    NamedCase(
        "25 us, saturation, L_m 30 % low",
        {"drive.period_us": 25, "control.machine_estimate.x_m_ohm": round(0.7 * 26.13, 3)} | SATURATION,
    ),
)
LINK_CASES = (NamedCase("25 us, link of 1 mF behind 0.2 ohm", {"drive.period_us": 25} | LINK),)
# By option: its cases, and what --help says.
PLANTS = {
    "drops": (DROPS_CASES, "the cases with drops in place of those with dead time"),
    "pulses": (PULSES_CASES, "those of gate drivers with a minimum pulse"),
    "saturation": (SATURATION_CASES, "those of a machine that saturates, with L_m right or low"),
    "iron": (IRON_CASES, "the drive of a machine with iron loss"),
    "link": (LINK_CASES, "that of a DC link with capacitance"),
    "everything": (EVERYTHING_CASES, "those with dead time, drops, saturation, sensors"),
}


def scenario() -> str:
    """The drive of configs/ecu.toml at an imposed speed."""
    return "\n".join([
        'name = "inverter_study"', f"duration_s = {END_S}",
        f'machine = "{ROOT}/configs/machines/paper_3hp.toml"',
        "[profile.torque_nm]", 'shape = "steps"', f"points = [[0, 0], [{STEP_S}, 0]]",
        "[load]", 'kind = "imposed_speed"',
        "[control]", "flux_reference_wb = 1.1", 'flux_estimator = "hybrid"',
        "[control.dtc]", "torque_band_upper_nm = 0.918", "torque_band_lower_nm = 0.918",
        "flux_band_wb = 0.01",
        "[command]", "torque_limit_nm = 150", "torque_rate_nm_s = 1e6",
        "[capability]", "torque_nm = 150",
        "[protection]", "over_current_a = 250", "dc_over_voltage_v = 700",
        "[torque_monitor]", "limit_nm = 10",
        "[plant]", "u_dc_v = 530", 'integrator = "exact"',
        "[metrics]", f"window_from_s = {FROM_S}",
    ]) + "\n"  # fmt: skip


def at(method: str, case: Case | NamedCase, speed: float) -> Settings:
    return {**case.settings, "control.controller": method, "load.speed_rad_s.value": float(speed)}


class Lab:
    def __init__(self, mil: Path, directory: Path) -> None:
        self.mil, self.file = mil, made(directory) / "inverter_study.toml"
        self.file.write_text(scenario(), encoding="utf-8")

    def metrics(self, settings: Settings) -> tuple[dict, list]:
        ended = run_of(self.mil, self.file, settings, TIME_LIMIT_S)
        if ended.summary is None:
            raise UserError(f"sextant-mil refuses the drive: {ended.said}.")
        return ended.summary["metrics"], ended.summary["faults"]

    def point(self, method: str, case: Case | NamedCase, speed: float, torque: float) -> dict:
        steps = {"profile.torque_nm.points": [[0, 0], [STEP_S, float(torque)]]}
        metrics, faults = self.metrics(at(method, case, speed) | steps)
        found = {"method": method, "case": case.name, "speed": speed, "torque": torque}
        return found | judged(metrics, faults, speed, torque)

    def idle(self, method: str, case: Case | NamedCase, speed: float) -> float:
        """Largest phase current without a command. [A]"""
        idle = {"duration_s": STEP_S, "metrics.window_from_s": 0.0, "profile.torque_nm.points": [[0, 0]]}
        return self.metrics(at(method, case, speed) | idle)[0]["peak_current_a"]

    def identified(self, case: Case) -> Case:
        """The plant of the case, whose drive is told what `identify` finds there with real sensors."""
        directory = self.file.parent / f"identify_{case.period_us}_{case.dead_us:g}{'_all' * case.everything}"
        plant = case.plant | SENSORS["real"]
        results = identification.identified(self.file, self.mil, directory, [identify.DEAD_TIME], plant)
        setup, found = results.setup, results.found
        told = told_dead_time_us(found)
        print(
            f"{case.period_us} us, dead time {case.dead_us:g} us: {told:g} us, R_s {found.r_s_ohm:.4f} ohm", flush=True
        )
        return replace(
            case, told_us=told, error_v=round(told_voltage_error_v(found, setup), 4), r_s_ohm=round(found.r_s_ohm, 5)
        )


def judged(metrics: dict, faults: list, speed: float, torque: float) -> dict:
    """What a run shows."""
    if faults:
        return {"kind": TRIPPED, "why": f"{faults[0]['fault']} at {faults[0]['t_s']:.3f} s"}
    if published(metrics, speed, torque) is None or metrics["torque_bias_nm"] is None:
        return {"kind": WRONG, "why": "no torque, no fault"}
    mean, due = mean_and_due(metrics, speed, torque)
    error = abs(mean - due)
    if error > max(TOLERANCE_NM, TOLERANCE_SHARE * abs(due)):
        return {"kind": WRONG, "why": f"{mean:.1f} N·m for {due:.1f} N·m"}
    return {"kind": DERATED if abs(due) < DERATED_SHARE * abs(torque) else RIGHT, "why": "", "error_nm": error}


def table(rows: list[dict], idle: dict[tuple[str, str], float]) -> str:
    head = (
        "on the plant",
        "method",
        *KINDS,
        f"wrong above {SLOW:g} rad/s",
        "largest error [N·m]",
        "A before a command",
    )
    cells = []
    for method, case in idle:
        own = [r for r in rows if (r["method"], r["case"]) == (method, case)]
        counts = Counter(r["kind"] for r in own)
        fast = sum(r["kind"] == WRONG and abs(r["speed"]) > SLOW for r in own)
        error = max((r["error_nm"] for r in own if "error_nm" in r), default=0)
        figures = (f"{error:.2f}", f"{idle[method, case]:.0f}")
        cells.append((case, method, *(counts[kind] for kind in KINDS), fast, *figures))
    return page.table(head, cells, left=(0, 1))


def numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f'expected numbers, got "{text}"') from None


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    description = "Measures the drive on a plant with dead time, drops or a minimum pulse, told of them or not."
    parser = parser_of("inverter_study", description, EXAMPLES)
    parser.add_argument("--methods", type=words, default=list(METHODS), metavar="A,B")
    parser.add_argument("--cases", default="", metavar="TEXT", help="those whose names begin with it (default: all)")
    plants = parser.add_mutually_exclusive_group()
    for name, (cases, said) in PLANTS.items():
        plants.add_argument(f"--{name}", dest="known", action="store_const", const=cases, default=CASES, help=said)
    parser.add_argument("--identified", action="store_true", help="each plant with dead time, as identify finds it")
    parser.add_argument("--speeds", type=numbers, default=list(SPEEDS), metavar="A,B", help="in rad/s")
    parser.add_argument("--torques", type=numbers, default=list(TORQUES), metavar="A,B", help="in N·m")
    add_runs(parser)
    return parser.parse_args(arguments)


def measure(lab: Lab, options: argparse.Namespace, cases: Iterable[Case | NamedCase]) -> tuple[list[dict], dict]:
    rows: list[dict] = []
    idle: dict[tuple[str, str], float] = {}
    with ThreadPoolExecutor(options.jobs) as pool:
        for method in options.methods:
            for case in cases:
                currents = pool.map(lambda speed, m=method, c=case: lab.idle(m, c, speed), options.speeds)
                work = [(method, case, speed, torque) for speed in options.speeds for torque in options.torques]
                found = list(pool.map(lambda one: lab.point(*one), work))
                rows += found
                idle[method, case.name] = max(currents)
                print(table(found, {(method, case.name): idle[method, case.name]}).splitlines()[-1], flush=True)
    return rows, idle


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    cases = [case for case in options.known if case.name.startswith(options.cases)]
    if not cases:
        names = "; ".join(case.name for case in options.known)
        raise UserError(f'--cases: none begins with "{options.cases}"; they are {names}.')
    directory = OUT / "inverter_study"
    lab = Lab(mil_program.find(options.mil), directory)
    if options.identified:
        plants = [c for c in cases if isinstance(c, Case) and c.dead_us and c.told_us == c.dead_us]
        if not plants:
            raise UserError("--identified: none of these plants has a dead time that could be found.")
        cases = [lab.identified(case) for case in plants]
    rows, idle = measure(lab, options, cases)
    print(table(rows, idle))
    file = directory / "inverter_study.json"
    json_file.write(file, rows)
    print(file)
    return 0


if __name__ == "__main__":
    run("inverter_study", main)
