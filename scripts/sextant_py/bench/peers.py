"""Stage: other open drive simulators on the same machine parameters, operating point and period."""

import hashlib
import json
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from .figure import Figure, NotMeasurableError
from .lab import Lab, Stage

REQUIREMENTS = ROOT / "scripts" / "requirements-peers.txt"
VENV = ROOT / ".cache" / "peers-venv"
LOG = ROOT / ".cache" / "peers.log"
MACHINE = ROOT / "configs" / "machines" / "paper_3hp.toml"
RUNS = Path(__file__).with_name("peer_runs.py")
ROUNDS = 3
TORQUE_NM, TORQUE_WITHIN_NM = 15.0, 3.0  # all stand at one operating point; PWM and switching ripple it

# tool: seconds to simulate, and its name
TOOLS = {
    "motulator": (0.05, "motulator, current-vector control with PWM"),
    "gem": (0.3, "gym-electric-motor, finite control set, no controller"),
    "gem_euler": (0.3, "gym-electric-motor with its Euler solver"),
}
# our integrator, tool, what they are, the target
RATIOS = (
    ("fixed", "motulator", TOOLS["motulator"][1], 5000.0),
    ("fixed", "gem", TOOLS["gem"][1], 1000.0),
    ("fixed", "gem_euler", TOOLS["gem_euler"][1], None),
    ("cvode", "motulator", "motulator, ours with CVODE", None),
    ("cvode", "gem", "gym-electric-motor, ours with CVODE", None),
)


def ratio(text: str, limit: float | None) -> Figure:
    return Figure(f"simulated seconds a second, ours / {text}", "x", at_least=limit)


def install(venv: Path = VENV, requirements: Path = REQUIREMENTS) -> Path:
    """The Python of the virtual environment, made where it is missing or out of date."""
    python, stamp = venv / "bin" / "python", venv / ".fingerprint"
    # Programs of a virtual environment name their interpreter by full path.
    fingerprint = hashlib.sha256(f"{requirements.read_text()}{sys.version}{venv}".encode()).hexdigest()
    if stamp.exists() and stamp.read_text() == fingerprint and python.exists():
        return python
    shutil.rmtree(venv, ignore_errors=True)
    LOG.parent.mkdir(parents=True, exist_ok=True)
    with LOG.open("w", encoding="utf-8") as log:
        for command in (
            [sys.executable, "-m", "venv", str(venv)],
            # Not what the two list for their own tests.
            [str(python), "-m", "pip", "install", "--no-deps", "--quiet", "--no-input", "-r", str(requirements)],
        ):
            if subprocess.run(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL).returncode != 0:
                raise UserError(f"the peers cannot be installed from {requirements.name}; .cache/peers.log tells why")
    stamp.write_text(fingerprint)
    return python


def run_peer(lab: Lab, python: Path, tool: str, seconds: float) -> dict:
    result = json.loads(lab.run(python, "-P", "-W", "ignore", RUNS, tool, str(seconds), MACHINE).splitlines()[-1])
    if abs(result["torque"] - TORQUE_NM) > TORQUE_WITHIN_NM:
        raise UserError(f"{tool} stands at {result['torque']:.1f} N·m instead of {TORQUE_NM:g}: not the same run")
    return result | {"factor": result["simulated_s"] / result["cpu_s"]}


def ours(lab: Lab) -> dict[str, float]:
    """Simulated seconds per second of CPU by integrator."""
    result = lab.google("^peer_loop/", "sextant_loop_bench", repetitions=5, min_time=0.05)
    return {kind: result.value(f"peer_loop/{kind}", "realtime_factor") for kind in ("fixed", "cvode")}


def compare(rounds: list[dict]) -> list[Figure]:
    """Figures of rounds; each holds `ours` by integrator and each tool's run. Ratios are taken within a round."""
    figures = []
    for kind, tool, text, limit in RATIOS:
        ratios = [one["ours"][kind] / one[tool]["factor"] for one in rounds]
        note = f"version {rounds[0][tool]['version']}; {min(ratios):.0f} to {max(ratios):.0f} in {len(rounds)} rounds"
        figures.append(ratio(text, limit).of(statistics.median(ratios), note))
    factors = {text: [one[tool]["factor"] for one in rounds] for tool, (_, text) in TOOLS.items()}
    for kind, text in (("fixed", "fixed step"), ("cvode", "CVODE")):
        factors[f"Sextant, {text}, same operating point"] = [one["ours"][kind] for one in rounds]
    plain = "simulated seconds a second of CPU, {}"
    return figures + [Figure(plain.format(text), value=statistics.median(each)) for text, each in factors.items()]


def peers(lab: Lab) -> list[Figure]:
    try:
        lab.say("installing the peers where they are missing")
        python = install()
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
