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

from .figure import Figure, unmeasured
from .lab import Lab, Stage

REQUIREMENTS = ROOT / "scripts" / "requirements-peers.txt"
VENV = ROOT / ".cache" / "peers-venv"
LOG = ROOT / ".cache" / "peers.log"
MACHINE = ROOT / "configs" / "machines" / "paper_3hp.toml"
RUNS = Path(__file__).with_name("peer_runs.py")
ROUNDS = 3
TORQUE_NM, TORQUE_WITHIN_NM = 15.0, 3.0  # all stand at one operating point; PWM and switching ripple it

# tool: seconds to simulate, its name, what of ours it is compared with, the target
PEERS = {
    "motulator": (0.05, "motulator, current-vector control with PWM", "fixed", 5000.0),
    "gem": (0.3, "gym-electric-motor, finite control set, no controller", "fixed", 1000.0),
    "gem_euler": (0.3, "gym-electric-motor with its Euler solver", "fixed", None),
    "motulator/cvode": (0.0, "motulator, ours with CVODE", "cvode", None),
    "gem/cvode": (0.0, "gym-electric-motor, ours with CVODE", "cvode", None),
}


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
    if result.errors:
        raise UserError("; ".join(f"{name}: {why}" for name, why in result.errors.items()))
    return {kind: result.median(f"peer_loop/{kind}", "realtime_factor") for kind in ("fixed", "cvode")}


def compare(rounds: list[dict]) -> list[Figure]:
    """Figures of rounds; each holds `ours` by integrator and each tool's run. Ratios are taken within a round."""
    figures, plain = [], []
    for name, (_, text, kind, limit) in PEERS.items():
        tool = name.split("/")[0]
        ratios = [one["ours"][kind] / one[tool]["factor"] for one in rounds]
        version = rounds[0][tool]["version"]
        figures.append(
            Figure(
                f"simulated seconds a second, ours / {text}",
                statistics.median(ratios),
                unit="x",
                at_least=limit,
                note=f"version {version}; {min(ratios):.0f} to {max(ratios):.0f} in {len(rounds)} rounds",
            )
        )
        if "/" not in name:
            factor = statistics.median(one[tool]["factor"] for one in rounds)
            plain.append(Figure(f"simulated seconds a second of CPU, {text}", factor))
    for kind, text in (("fixed", "fixed step"), ("cvode", "CVODE")):
        factor = statistics.median(one["ours"][kind] for one in rounds)
        plain.append(Figure(f"simulated seconds a second of CPU, Sextant, {text}, same operating point", factor))
    return figures + plain


def peers(lab: Lab) -> list[Figure]:
    try:
        lab.say("installing the peers where they are missing")
        python = install()
    except UserError as error:
        return [
            unmeasured(f"simulated seconds a second, ours / {text}", str(error), unit="x", at_least=limit)
            for _, text, _, limit in PEERS.values()
            if limit is not None
        ]
    rounds = []
    for number in range(ROUNDS):
        lab.say(f"round {number + 1} of {ROUNDS}")
        one: dict = {"ours": ours(lab)}
        for tool, (seconds, *_) in PEERS.items():
            if "/" not in tool:
                one[tool] = run_peer(lab, python, tool, seconds)
        rounds.append(one)
    return compare(rounds)


PEERS_STAGE = Stage("peers", "other simulators at the same operating point", 60, peers)
