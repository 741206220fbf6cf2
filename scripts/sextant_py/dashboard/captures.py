"""The newest captures, which every page can save, whichever page's scope made them."""

import tempfile
import threading
from pathlib import Path

from ..scope import files
from ..scope.capture import Capture

KEPT = 16


class Captures:
    """Numbers and keeps captures; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._writing = threading.Lock()
        self._kept: dict[int, tuple[int, Capture]] = {}
        self._number = 0

    def add(self, drive_id: int, capture: Capture) -> int:
        """The capture's number."""
        with self._lock:
            self._number += 1
            self._kept[self._number] = (drive_id, capture)
            self._kept.pop(self._number - KEPT, None)
            return self._number

    def recording(self, number: int) -> bytes | None:
        """The bytes of a capture's recording; None where it is not kept. One is written at a time."""
        with self._lock:
            found = self._kept.get(number)
        if found is None:
            return None
        with self._writing, tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "capture.h5")
            files.write(path, found[1], found[0])
            return path.read_bytes()
