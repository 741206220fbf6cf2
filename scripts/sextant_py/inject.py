"""Gives a running simulated plant a fault: `sextant.inject`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import UserError, run
from .local_request import described, order
from .program_arguments import parser_of
from .sweep_reader import toml_value

EXAMPLES = """examples:
  sextant-ecu configs/ecu.toml --fault-socket /tmp/faults     in another shell; sextant-plant takes it too
  scripts/inject /tmp/faults open_phase phase=b               from now on
  scripts/inject /tmp/faults speed_jump jump_rad_s=20 until_s=0.05
  scripts/inject /tmp/faults link_sag at_s=2 sag_v=300 ramp_ms=10
  scripts/inject /tmp/faults none                             ends it

Kinds and keys are those of [plant.faults] (docs/sensors.md); at_s and until_s count from now. Keys that are not given
are those of the program's file. A fault takes the place of the one before. The program logs each with its time."""


def inject(fault_socket: str | Path, kind: str, **values: Any) -> None:
    """Gives the simulated plant of a running sextant-ecu or sextant-plant a fault, from its next control period on.

    fault_socket: its --fault-socket
    kind: of plant.faults.kind; "none" ends the fault
    values: other keys of [plant.faults], as until_s=0.05; at_s and until_s count from now

    What the program refuses, and one that is not there, is a UserError with one sentence.
    """
    give(fault_socket, {"kind": kind, **values})


def give(fault_socket: str | Path, values: Mapping[str, Any]) -> None:
    """The same by keys of [plant.faults], `kind` among them."""
    if not values:
        raise UserError("the fault is refused: no key of [plant.faults] is given; kind=none ends a fault.")
    _order(fault_socket, "".join(f"{key}={toml_value(value)}\n" for key, value in values.items()))


def keys(fault_socket: str | Path) -> list[dict[str, Any]]:
    """What a fault may be, as the program describes it: objects of key, unit, meaning and choices, or least and most.

    A program that is not there, or of another version, is a UserError with one sentence.
    """
    return described(fault_socket, _absent(fault_socket))


def _order(fault_socket: str | Path, request: str) -> None:
    order(fault_socket, request, "the fault", _absent(fault_socket))


def _absent(fault_socket: str | Path) -> str:
    return f"no program takes faults; start sextant-ecu or sextant-plant with --fault-socket {fault_socket}."


def main(arguments: list[str]) -> int:
    parser = parser_of(
        "inject", "Gives the simulated plant of a running sextant-ecu or sextant-plant a fault.", EXAMPLES
    )
    parser.add_argument("socket", type=Path, metavar="SOCKET", help="the --fault-socket of the program")
    parser.add_argument("kind", metavar="KIND", help='of plant.faults.kind; "none" ends the fault')
    parser.add_argument("values", nargs="*", metavar="KEY=VALUE", help="other keys of [plant.faults]")
    options = parser.parse_args(arguments)
    for text in options.values:
        if "=" not in text or not text.isprintable():
            parser.error(f'"{text}" is not KEY=VALUE')
    _order(options.socket, "".join(f"{text}\n" for text in (f"kind={toml_value(options.kind)}", *options.values)))
    return 0


if __name__ == "__main__":
    run("inject", main)
