"""One thread of a process made to stand still from outside, while the others run on."""

import ctypes
import os
from pathlib import Path

_SEIZE, _INTERRUPT, _DETACH = 0x4206, 0x4207, 17
_WALL = 0x40000000  # waitpid: threads as well


def thread_id(process: int, name: str) -> int:
    """The thread of the process that has this name."""
    for task in Path(f"/proc/{process}/task").iterdir():
        if (task / "comm").read_text(encoding="ascii").strip() == name:
            return int(task.name)
    raise LookupError(f"process {process} has no thread {name}")


class HeldThread:
    """Stops the thread for the time of a `with`, as a debugger does."""

    def __init__(self, process: int, name: str) -> None:
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._thread = thread_id(process, name)

    def _ptrace(self, request: int) -> None:
        arguments = (ctypes.c_long(request), ctypes.c_long(self._thread), ctypes.c_void_p(), ctypes.c_void_p())
        if self._libc.ptrace(*arguments) < 0:
            raise OSError(ctypes.get_errno(), f"ptrace({request:#x}) of thread {self._thread}")

    def __enter__(self) -> "HeldThread":
        self._ptrace(_SEIZE)
        self._ptrace(_INTERRUPT)
        os.waitpid(self._thread, _WALL)
        return self

    def __exit__(self, *_: object) -> None:
        self._ptrace(_DETACH)
