"""sextant COMMAND [ARGUMENTS...]: the programs of scripts/ that people use, as one command of the Python package."""

import argparse
import importlib
import importlib.metadata
import sys
import tomllib

from . import completion, shell_request
from .commands import COMMANDS
from .errors import REFUSED, run
from .paths import IS_CHECKOUT, ROOT


def answer_shell() -> None:
    """Completes the line of a shell: a command, or what the command takes."""
    name = completion.command_of_request()
    if name:
        run(name, importlib.import_module(f"sextant_py.{name}").main)
    shell_request.answer_request()
    parser = argparse.ArgumentParser(prog="sextant")
    parser.add_argument("command", choices=COMMANDS if name is None else ())
    parser.parse_args()


def version() -> str:
    if not IS_CHECKOUT:
        return importlib.metadata.version("sextant")
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def command() -> None:
    if shell_request.is_requested():
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
