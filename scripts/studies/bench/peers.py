"""Stage: other open drive simulators on the same machine parameters, operating point and period."""

import json
import statistics
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from . import peer_python
from .figure import Figure, NotMeasurableError
from .lab import Lab, Stage

MACHINE = ROOT / "configs" / "machines" / "paper_3hp.toml"
ROUNDS = 3
TORQUE_NM, TORQUE_WITHIN_NM = 15.0, 3.0  # all stand at one operating point; PWM and switching ripple it

# tool: seconds to simulate, and its name
TOOLS = {
    "motulator": (0.05, "motulator, current-vector control with PWM"),
    "motulator_averaged": (0.05, "motulator, current-vector control, the inverter's voltage averaged"),
    "gem": (0.3, "gym-electric-motor, finite control set, no controller"),
    "gem_euler": (0.3, "gym-electric-motor with its Euler solver"),
}
# our integrator, tool, what they are, the target
RATIOS = (
    ("fixed", "motulator", TOOLS["motulator"][1], 5000.0),
    ("fixed", "motulator_averaged", TOOLS["motulator_averaged"][1], None),
    ("fixed", "gem", TOOLS["gem"][1], 1000.0),
    ("fixed", "gem_euler", TOOLS["gem_euler"][1], None),
    ("cvode", "motulator", "motulator, ours with CVODE", None),
    ("cvode", "gem", "gym-electric-motor, ours with CVODE", None),
)


def ratio(text: str, limit: float | None) -> Figure:
    return Figure(f"simulated seconds a second, ours / {text}", "x", at_least=limit)


def run_peer(lab: Lab, python: Path, tool: str, seconds: float) -> dict:
    command = ("env", f"PYTHONPATH={ROOT / 'scripts'}", "PYTHONDONTWRITEBYTECODE=1", python, "-W", "ignore")
    said = lab.run(*command, "-m", "studies.bench.peer_runs", tool, str(seconds), MACHINE)
    result = json.loads(said.splitlines()[-1])
    if abs(result["torque"] - TORQUE_NM) > TORQUE_WITHIN_NM:
        raise UserError(f"{tool} stands at {result['torque']:.1f} N·m instead of {TORQUE_NM:g}: not the same run")
    return result | {"factor": result["simulated_s"] / result["cpu_s"]}


def ours(lab: Lab) -> dict[str, float]:
    """Simulated seconds per second of CPU by integrator."""
    result = lab.google("^peer_loop/", "sextant_loop_bench", repetitions=5, min_time=0.05)
    return {kind: result.value(f"peer_loop/{kind}", "realtime_factor") for kind in ("fixed", "cvode")}


def origin(run: dict) -> str:
    return f"version {run['version']}, Python {run['python']}"


def compare(rounds: list[dict]) -> list[Figure]:
    """Figures of rounds; each holds `ours` by integrator and each tool's run. Ratios are taken within a round."""
    figures = []
    for kind, tool, text, limit in RATIOS:
        ratios = [one["ours"][kind] / one[tool]["factor"] for one in rounds]
        note = f"{origin(rounds[0][tool])}; {min(ratios):.0f} to {max(ratios):.0f} in {len(rounds)} rounds"
        figures.append(ratio(text, limit).of(statistics.median(ratios), note))
    for tool, (_, text) in TOOLS.items():
        figures.append(speed(text, [one[tool]["factor"] for one in rounds], origin(rounds[0][tool])))
    for kind, text in (("fixed", "fixed step"), ("cvode", "CVODE")):
        figures.append(speed(f"Sextant, {text}, same operating point", [one["ours"][kind] for one in rounds]))
    return figures


def speed(text: str, factors: list[float], note: str = "") -> Figure:
    return Figure(f"simulated seconds a second of CPU, {text}", value=statistics.median(factors), note=note)


def peers(lab: Lab) -> list[Figure]:
    try:
        lab.say("installing the peers where they are missing")
        python = peer_python.install()
    except UserError as error:
        why = NotMeasurableError(str(error))
        return [ratio(text, limit).failed(why) for _, _, text, limit in RATIOS if limit is not None]
    rounds = []
    for number in range(ROUNDS):
        lab.say(f"round {number + 1} of {ROUNDS}")
        theirs = {tool: run_peer(lab, python, tool, seconds) for tool, (seconds, _) in TOOLS.items()}
        rounds.append({"ours": ours(lab), **theirs})
    return compare(rounds)


PEERS_STAGE = Stage("peers", "other simulators at the same operating point", 60, peers)
