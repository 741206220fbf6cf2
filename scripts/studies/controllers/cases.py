"""The runs of the bench of control methods: what each sets beside the drive of configs/ecu.toml."""

import itertools
from dataclasses import dataclass

from sextant_py.paths import ROOT
from sextant_py.sweep_file import Settings

from studies.torque_map.drive import DELAY, FACTORS, Drive
from studies.torque_map.scale import SENSORS

SPEEDS = (-100, -20, -5, 0, 5, 20, 50, 75, 100, 130, 200, 300)  # mechanical [rad/s]
TORQUES = (-130, -60, -15, 2, 15, 60, 130)  # [N·m]
QUICK_SPEEDS, QUICK_TORQUES = (0, 50, 100), (15, 60)
PERIODS_US = (5, 10, 12.5, 20, 25, 40, 50, 100)  # of which each method gets the one nearest to SWITCHING_HZ
SWITCHING_HZ = 10_000  # of a leg at the operating point of REFERENCE [Hz]
REFERENCE = (50, 60)  # [rad/s], [N·m]
STEP_S, WINDOW_S, END_S = 0.35, 0.5, 0.8
NYCC_S = 598

LOW_SPEED = 20  # up to which the page judges low speed [rad/s]

# A machine that is not what the controller believes, and sensors that are not ideal.
PARAMETERS = FACTORS | {"l_ls": "x_ls_ohm", "l_lr": "x_lr_ohm"}
DETUNED = {
    "exact parameters": {},
    "R_s ×1.5": {"r_s": 1.5},
    "R_r ×1.5": {"r_r": 1.5},
    "L_m ×0.7": {"l_m": 0.7},
    "leakage ×0.5": {"l_ls": 0.5, "l_lr": 0.5},
    "leakage ×1.5": {"l_ls": 1.5, "l_lr": 1.5},
}

# Without a speed sensor: the two best methods, by the estimator that estimates the speed too.
BEST = ("foc", "deadbeat")
SENSORLESS_SPEEDS = (20, 50, 100, 200)  # [rad/s]
SENSORLESS_TORQUES = (15, 60, -60)  # [N·m]
OPTIMA = ("constant", "max_torque_per_ampere", "min_loss")  # of drive.flux_optimum


@dataclass(frozen=True)
class Case:
    """One run: its section of the page, the method, and what tells it from the others there."""

    section: str
    method: str
    what: tuple
    settings: tuple  # of pairs of key and value

    @staticmethod
    def of(section: str, method: str, what: tuple, settings: Settings) -> "Case":
        return Case(section, method, what, tuple(settings.items()))


def at(speed: float, torque: float, period_us: float) -> Settings:
    """A step to a torque at an imposed speed, with the machine magnetised before, and a period of delay."""
    return {
        "duration_s": END_S,
        "drive.period_us": period_us,
        DELAY: 1,
        "load.kind": "imposed_speed",
        "load.speed_rad_s.value": speed,
        "profile.torque_nm.shape": "steps",
        "profile.torque_nm.points": [[0, 0], [STEP_S, torque]],
        "metrics.step_s": STEP_S,
        "metrics.window_from_s": WINDOW_S,
    }


def grid(section: str, method: str, period_us: float, speeds: tuple, torques: tuple) -> list[Case]:
    points = itertools.product(speeds, torques)
    return [Case.of(section, method, point, at(*point, period_us)) for point in points]


def tuning(method: str) -> list[Case]:
    """The reference point at every period, to find the one with the switching frequency in common."""
    return [Case.of("tuning", method, (period,), at(*REFERENCE, period)) for period in PERIODS_US]


def starts(method: str) -> list[Case]:
    """From a dead machine at standstill to 15 N·m, with a limit of the current, as the drive magnetises."""
    cases = []
    for limit in (20, 40):
        settings = at(0, 15, 25) | {
            "profile.torque_nm.points": [[0, 15]],
            "metrics.step_s": 0,
            f"control.{method}.magnetising_current_a": limit,
            f"control.{method}.hand_over_current_a": limit,
        }
        cases.append(Case.of("start", method, (limit,), settings))
    return cases


def standstill(method: str) -> list[Case]:
    """15 N·m at standstill for 10 s."""
    return [Case.of("standstill", method, (), at(0, 15, 25) | {"duration_s": WINDOW_S + 10})]


def sensorless(method: str) -> list[Case]:
    points = itertools.product(SENSORLESS_SPEEDS, SENSORLESS_TORQUES) if method in BEST else ()
    estimator = {"control.flux_estimator": "sensorless_observer"}
    return [Case.of("sensorless", method, point, at(*point, 25) | estimator) for point in points]


def detuned(method: str, drive: Drive) -> list[Case]:
    cases = []
    for (name, factors), sensors in itertools.product(DETUNED.items(), SENSORS):
        believed = {f"control.machine_estimate.{key}": drive.machine[key] for key in PARAMETERS.values()}
        real = {f"machine.{PARAMETERS[k]}": drive.machine[PARAMETERS[k]] * factor for k, factor in factors.items()}
        settings = at(*REFERENCE, 25) | believed | real | SENSORS[sensors]
        cases.append(Case.of("detuned", method, (name, sensors), settings))
    return cases


def cycle(method: str, optimum: str = "constant") -> Case:
    """The New York City Cycle with the paper's load, the table of torque and speed clipped."""
    settings = {
        "duration_s": NYCC_S,
        DELAY: 1,
        "drive.flux_optimum": optimum,
        "cycle.file": str(ROOT / "configs/cycles/nycc.csv"),
        "cycle.table": str(ROOT / "configs/vehicles/passive_ev.csv"),
        "cycle.extrapolation": "clip",
        "metrics.window_from_s": 0.5,
    }
    return Case.of("cycle", method, (optimum,), settings)


def cycles(method: str) -> list[Case]:
    """With the configured flux; of the paper's method and the two best also with every optimum."""
    return [cycle(method, optimum) for optimum in (OPTIMA if method in ("dtc", *BEST) else OPTIMA[:1])]
