"""A file that grows by whole pieces: one that finds no room leaves no half behind."""

import os
from pathlib import Path


class AppendFile:
    """Nothing is buffered: what was appended has reached the operating system, and closing writes nothing."""

    def __init__(self, path: Path, keep: bool = False) -> None:
        """keep: what the file holds stays; otherwise it begins empty."""
        self._file = path.open("ab" if keep else "wb", buffering=0)

    def append(self, text: str) -> None:
        """OSError where there is no room; the file is then as it was before."""
        self.append_bytes(text.encode())

    def append_bytes(self, data: bytes) -> None:
        """As append."""
        size = os.fstat(self._file.fileno()).st_size
        left = memoryview(data)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError:
            self.truncate(size)
            raise

    def truncate(self, size: int) -> None:
        """Gives up what stands behind so many bytes."""
        self._file.truncate(size)
        self._file.seek(size)

    def sync(self) -> None:
        """Returns when everything is on the disk."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        self._file.close()
