"""Shows parameters of a running drive."""

import difflib
from pathlib import Path

from .errors import UserError, run
from .program_arguments import parser_of
from .set import listed, parameters

EXAMPLES = """examples:
  sextant-ecu configs/ecu.toml --set-socket /tmp/set     in another shell
  scripts/get /tmp/set                                   every key, when it may change, and its value
  scripts/get /tmp/set protection                        those of a table
  scripts/get /tmp/set protection.over_current_a control.foc"""


def is_of(key: str, wanted: str) -> bool:
    """The key itself, or one of the table of that name."""
    return key == wanted or key.startswith(f"{wanted}.")


def main(arguments: list[str]) -> int:
    parser = parser_of(
        "get", "Shows parameters of the drive of a running sextant-ecu, and when they may change.", EXAMPLES
    )
    parser.add_argument("socket", type=Path, metavar="SOCKET", help="the --set-socket of the program")
    parser.add_argument("keys", nargs="*", metavar="KEY", help="a key, or a table with all of its keys; default: all")
    options = parser.parse_args(arguments)
    known = parameters(options.socket)
    for key in options.keys:
        if not any(is_of(one["key"], key) for one in known):
            nearest = difflib.get_close_matches(key, [one["key"] for one in known], 1, 0)
            raise UserError(f"{key}: unknown key; the nearest known one is {nearest[0]}.")
    for one in known:
        if not options.keys or any(is_of(one["key"], key) for key in options.keys):
            print(listed(one))
    return 0


if __name__ == "__main__":
    run("get", main)
