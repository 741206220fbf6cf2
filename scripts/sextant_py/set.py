"""Sets parameters of a running drive: `sextant.set_parameters`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import UserError, run
from .local_request import described, order
from .program_arguments import parser_of
from .sweep_reader import toml_value

EXAMPLES = """examples:
  sextant-ecu configs/ecu.toml --set-socket /tmp/set                in another shell
  scripts/set /tmp/set protection.over_current_a=80                 from the next wake-up of the control thread on
  scripts/set /tmp/set control.dtc.flux_band_wb=0.02 control.dtc.torque_trim_ms=5
  scripts/get /tmp/set                                              every key, when it may change, and its value

Keys and values are those of --set. What follows from a key that is set changes with it, unless the file or an earlier
set gives it. All keys of one command are taken at once, or none. docs/configuration.md tells which may change when."""


def set_parameters(set_socket: str | Path, values: Mapping[str, Any]) -> list[str]:
    """Sets keys of the drive of a running sextant-ecu, as {"protection.over_current_a": 80}; all at once, or none.

    set_socket: its --set-socket

    The result names each value that has become another one. What the drive refuses, and a program that is not there, is
    a UserError with one sentence.
    """
    if not values:
        raise UserError("no key is set: give keys and values, or ask with get_parameters.")
    for key in values:
        if not key.isprintable() or "=" in key:
            raise UserError(f"{key!r} is no key.")
    return _order(set_socket, [f"{key}={toml_value(value)}" for key, value in values.items()])


def parameters(set_socket: str | Path) -> list[dict[str, Any]]:
    """The keys of a running drive: objects of key, unit, meaning, changes, value and choices, or least and most."""
    return described(set_socket, _absent(set_socket))


def get_parameters(set_socket: str | Path) -> dict[str, Any]:
    """The values that the drive of a running sextant-ecu runs with, by their keys; None where one is not set."""
    return {one["key"]: one["value"] for one in parameters(set_socket)}


def _order(set_socket: str | Path, lines: list[str]) -> list[str]:
    return order(set_socket, "\n".join(lines), "the change", _absent(set_socket))


def _absent(set_socket: str | Path) -> str:
    return f"no drive takes parameters; start sextant-ecu with --set-socket {set_socket}."


def listed(one: Mapping[str, Any]) -> str:
    """A key of the list as a line: when it may change, key, value, unit and range."""
    allowed = "|".join(one.get("choices", ()))
    if "least" in one:
        allowed = f"{one['least']:g} to {one['most']:g}"
    value = "not set" if one["value"] is None else toml_value(one["value"])
    unit = f" {one['unit']}" if one["unit"] else ""
    return f"{one['changes']:<10} {one['key']} = {value}{unit}{f'  ({allowed})' if allowed else ''}"


def main(arguments: list[str]) -> int:
    parser = parser_of("set", "Sets parameters of the drive of a running sextant-ecu.", EXAMPLES)
    parser.add_argument("socket", type=Path, metavar="SOCKET", help="the --set-socket of the program")
    parser.add_argument("values", nargs="+", metavar="KEY=VALUE", help="keys and values as of --set")
    options = parser.parse_args(arguments)
    for text in options.values:
        if "=" not in text or not text.isprintable():
            parser.error(f'"{text}" is not KEY=VALUE')
    changed = _order(options.socket, options.values)
    print("\n".join(changed) or "no value has become another one")
    return 0


if __name__ == "__main__":
    run("set", main)
