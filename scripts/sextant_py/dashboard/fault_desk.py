"""Faults for the simulated plant, from the page that commands."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from .. import inject
from ..errors import UserError
from .command_desk import RefusedError

Answer = dict[str, Any]


class FaultDesk:
    """Asks the program behind a fault socket, one question at a time; what there is to choose is the program's."""

    def __init__(self, fault_socket: Path) -> None:
        self._socket = fault_socket
        self._is_asking = False

    def question(self, message: dict[str, Any]) -> Callable[[], Answer]:
        """What a page's message asks, for another thread: it may take seconds. Its result is for the page.

        "fault_keys" asks for the keys, "fault" gives the plant the fault of "values".
        """
        if self._is_asking:
            raise RefusedError("the plant has not replied to the request before.")
        values = message.get("values")
        if message["type"] == "fault" and not is_fault(values):
            raise RefusedError("values must be an object of numbers and texts by key.")
        self._is_asking = True
        return partial(self._answer, self._keys if message["type"] == "fault_keys" else partial(self._give, values))

    def _answer(self, ask: Callable[[], Answer]) -> Answer:
        try:
            return ask()
        except UserError as error:
            return {"type": "fault_reply", "problem": str(error)}
        finally:
            self._is_asking = False

    def _keys(self) -> Answer:
        return {"type": "faults", "keys": inject.keys(self._socket)}

    def _give(self, values: dict[str, Any]) -> Answer:
        inject.give(self._socket, values)
        return {"type": "fault_reply", "problem": None, "kind": values.get("kind")}


def is_fault(values: object) -> bool:
    """Whether it is a request in form; the program judges keys and values."""
    return isinstance(values, dict) and all(
        key.isidentifier() and isinstance(value, int | float | str) and not isinstance(value, bool)
        for key, value in values.items()
    )
