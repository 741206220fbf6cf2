"""The steady torque at imposed speeds with a wrong stator resistance, 15 N·m commanded."""

from concurrent.futures import ThreadPoolExecutor

from sextant_py.sweep_file import Settings

from .points import DETUNES, Conditions, machine_settings
from .run import Lab

TORQUE_NM = 15.0
# Factor of the stator resistance, speed [rad/s].
CASES = (
    (1.2, 0),
    (1.2, 50),
    (1.2, 100),
    (0.8, 0),
    (0.5, -50),
    (0.5, -200),
    (1.0, 160),
    (1.0, 200),
)


def cases(detune: str) -> list[tuple[float, float]]:
    """Those of a detune; without a factor both are the same, and it counts as the machine's."""
    return [(factor, speed) for factor, speed in CASES if factor != 1 or detune == "machine"]


def settings(lab: Lab, factor: float, speed: float, detune: str) -> Settings:
    return {
        "duration_s": 2,
        "metrics.window_from_s": 1,
        "plant.integrator": "fixed",
        "profile.torque_nm.value": TORQUE_NM,
        "load.kind": "imposed_speed",
        "load.speed_rad_s.value": speed,
        **machine_settings(lab.drive, Conditions(r_s=factor, detune=detune)),
    }


def _measure(lab: Lab, factor: float, speed: float, detune: str) -> dict:
    record = lab.run_one("", settings(lab, factor, speed, detune))
    found = {"r_s": factor, "speed": speed, "detune": detune, "torque_nm": None, "ripple_nm": None, "fault": ""}
    if record["reason"]:
        return found | {"fault": record["reason"]}
    found["torque_nm"] = round(TORQUE_NM + record["torque_bias_nm"], 2)
    found["ripple_nm"] = round(record["torque_ripple_pp_nm"], 1)
    found["gates_off"] = record["torque_deviation_nm"] is None
    if record["faults"]:
        found["fault"] = "{} at {:.3g} s".format(*record["faults"][0])
    return found


def measure(lab: Lab, jobs: int) -> list[dict]:
    """Mean torque over the last second of two, with the factor on the machine and on what the controller believes."""
    with ThreadPoolExecutor(jobs) as pool:
        begun = [pool.submit(_measure, lab, factor, speed, d) for d in DETUNES for factor, speed in cases(d)]
        return [one.result() for one in begun]
