"""sextant COMMAND [ARGUMENTS...]: the programs of scripts/ that people use, as one command of the Python package."""

import argparse
import importlib
import importlib.metadata
import sys
import tomllib

from . import completion
from .errors import REFUSED, run
from .paths import IS_CHECKOUT, ROOT

COMMANDS = {
    "vcu": "plays a torque profile to a drive over CAN",
    "monitor": "shows the telemetry of the drives on the network",
    "dashboard": "serves a page with the live telemetry of the drives",
    "record": "records the telemetry of one drive",
    "convert": "converts recordings between file formats",
    "playback": "plays a recording over DDS and CAN",
    "scope": "captures the waveform around a trigger",
    "plot": "draws a trace or a recording",
    "compare": "compares two runs metric by metric",
    "report": "makes a page for people from runs and recordings",
    "expect": "evaluates a recording by the limits of a scenario",
    "sweep": "runs a scenario at many points of its configuration",
    "nameplate": "makes machine, limits and configurations of a drive from a name plate",
    "identify": "measures inverter and stator at standstill, for the drive",
    "inject": "gives a running simulated plant a fault",
    "set": "sets parameters of a running drive",
    "get": "shows parameters of a running drive",
    "completion": "prints what a shell needs to complete these commands",
    "rt_check": "says what keeps this machine from hard real time",
}


def answer_shell() -> None:
    """Completes the line of a shell: a command, or what the command takes."""
    name = completion.command_of_request(COMMANDS)
    if name:
        run(name, importlib.import_module(f"sextant_py.{name}").main)
    completion.answer_request()
    parser = argparse.ArgumentParser(prog="sextant")
    parser.add_argument("command", choices=COMMANDS if name is None else ())
    parser.parse_args()


def version() -> str:
    if not IS_CHECKOUT:
        return importlib.metadata.version("sextant")
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def command() -> None:
    if completion.is_requested():
        answer_shell()
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name in COMMANDS:
        sys.argv = [f"sextant {name}", *sys.argv[2:]]
        run(name, importlib.import_module(f"sextant_py.{name}").main)
    listed = "\n".join(f"  {key:<10} {text}" for key, text in COMMANDS.items())
    if name == "--version":
        print(version())
        sys.exit(0)
    if name in ("", "-h", "--help"):
        print(f"usage: sextant COMMAND [ARGUMENTS...]; sextant COMMAND --help tells more\n\n{listed}")
        sys.exit(0 if name else REFUSED)
    print(f'sextant: unknown command "{name}"; known are {", ".join(COMMANDS)}.', file=sys.stderr)
    sys.exit(REFUSED)


if __name__ == "__main__":
    command()
