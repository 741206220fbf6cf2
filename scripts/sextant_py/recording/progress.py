"""How far long work is, on one line of a terminal; nothing where there is none."""

import sys
import time

EVERY_S = 0.5


class Progress:
    def __init__(self) -> None:
        self._shown_s = float("-inf")
        self._width = 0
        self._is_terminal = sys.stderr.isatty()

    def show(self, text: str) -> None:
        if not self._is_terminal or time.monotonic() - self._shown_s < EVERY_S:
            return
        self._shown_s = time.monotonic()
        print(f"\r{text:<{self._width}}", end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def end(self) -> None:
        """Clears the line."""
        if self._width:
            print(f"\r{'':<{self._width}}\r", end="", file=sys.stderr, flush=True)
            self._width = 0
