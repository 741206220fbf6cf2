"""Writing a recording beside the one that it replaces."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import UserError
from .formats import AT_THE_END, earlier, open_sink
from .model import Metadata, Sink


@contextmanager
def replacing(output: Path, what: str = "") -> Iterator[Path]:
    """The path to write to, in a folder beside the output. At the end its files replace the recording at the output,
    of which no file stays; after an error what is there stays. `what` is for the sentence of an OSError."""
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(
            prefix=f".{output.name}.", dir=output.parent, ignore_cleanup_errors=True
        ) as folder:
            yield Path(folder) / output.name
            _move(Path(folder), output)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else error
        raise UserError(f"{what}{output} cannot be written: {reason}; nothing of it is kept.") from None


def _move(folder: Path, output: Path) -> None:
    old, new = earlier(output), [output.with_name(place.name) for place in folder.iterdir()]
    for place in new:
        (folder / place.name).replace(place)
    for place in set(old) - set(new):
        place.unlink()


@contextmanager
def whole_sink(path: Path, metadata: Metadata) -> Iterator[Sink]:
    """A sink, to be ended by `close_whole`; an error leaves files that are to be removed."""
    sink = open_sink(path, metadata)
    try:
        yield sink
    except BaseException:
        _abandon(sink, path, metadata)
        raise


def close_whole(sink: Sink, metadata: Metadata, rows: dict[str, int]) -> None:
    """Closes the sink that has taken these rows. OSError where it has not kept them all: on a full disk the last ones
    may make way for the end of the file."""
    sink.close({**metadata, "rows": rows})
    if dict(sink.kept) != rows:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _abandon(sink: Sink, path: Path, metadata: Metadata) -> None:
    with suppress(Exception):
        if path.suffix in AT_THE_END:
            sink.abandon()
        else:
            sink.close(metadata)
