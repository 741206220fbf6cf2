"""sextant completion bash|zsh: what a shell needs to complete options and arguments of the programs."""

import argparse
import os
import sys

from .commands import COMMANDS
from .errors import run
from .paths import ROOT
from .shell_request import REQUESTED

EXAMPLES = """examples:
  eval "$(sextant completion bash)"             of the installed command, in ~/.bashrc
  eval "$(scripts/completion bash)"             of scripts/plot and so on, typed in the checkout's directory
  source <(scripts/completion zsh)              for zsh, after compinit"""


def command_of_request() -> str | None:
    """The command after `sextant` of the line to be completed; None while it is being typed.

    Whatever precedes the command's own arguments is then passed over.
    """
    line = os.environ.get("COMP_LINE", "")[: int(os.environ.get("COMP_POINT", "0") or 0)]
    words = line.split()
    if len(words) > 2 or (len(words) == 2 and line.endswith(" ")):
        os.environ[REQUESTED] = "2"
        return words[1] if words[1] in COMMANDS else ""
    return None


def programs() -> list[str]:
    """`sextant` where it is installed; in a checkout the programs of scripts/ that are argparse's."""
    scripts = ROOT / "scripts"
    here = [name for name in COMMANDS if os.access(scripts / name, os.X_OK)]
    return ["sextant", *(f"{prefix}scripts/{name}" for name in here for prefix in ("", "./"))]


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="completion",
        description="Prints what a shell needs to complete options and arguments of the programs.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("shell", choices=("bash", "zsh"))
    shell = parser.parse_args(arguments).shell
    import argcomplete

    sys.stdout.write(argcomplete.shellcode(programs(), shell=shell))
    return 0


if __name__ == "__main__":
    run("completion", main)
