"""The file formats of recordings, by suffix."""

import errno
import os
from importlib import import_module
from pathlib import Path

from ..errors import UserError
from .checked import CheckedSource
from .model import Metadata, Sink, Source, unreadable

# Imported when they are needed: MDF alone takes a second.
_FORMATS = {
    ".h5": (".hdf5_file", "Hdf5Sink", ".hdf5_file", "Hdf5Source"),
    ".csv": (".csv_file", "CsvSink", ".csv_file", "CsvSource"),
    ".mcap": (".mcap_sink", "McapSink", ".mcap_source", "McapSource"),
    ".mf4": (".mdf_file", "MdfSink", ".mdf_file", "MdfSource"),
    ".parquet": (".parquet_file", "ParquetSink", ".parquet_file", "ParquetSource"),
}
SUFFIXES = tuple(_FORMATS)
AT_THE_END = (".mf4", ".parquet")  # readable only once they are complete
# How a file that is compressed as a whole begins, and what unpacks it.
COMPRESSED = {
    **{b"\x1f\x8b": "gzip -d", b"\x28\xb5\x2f\xfd": "zstd -d", b"\xfd7zXZ": "xz -d"},
    **{b"BZh": "bzip2 -d", b"PK\x03\x04": "unzip"},
}
SEVERAL = (".csv", ".parquet")  # a file a group


def check(path: Path) -> None:
    """Refuses a suffix that names no format."""
    if path.suffix.lower() not in SUFFIXES:
        raise UserError(f'{path}: a recording ends in {", ".join(SUFFIXES)}, and "{path.suffix}" is none of them.')


def open_sink(path: Path, metadata: Metadata) -> Sink:
    """OSError where it cannot be written."""
    check(path)
    module, name, _, _ = _FORMATS[path.suffix.lower()]
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() in SEVERAL:
        for place in earlier(path):
            place.unlink()
    return getattr(import_module(module, __package__), name)(path, metadata)


def files(path: Path, names: list[str], main: str) -> list[Path]:
    if path.suffix.lower() not in SEVERAL:
        return [path]
    from .arrow_table import file_of

    beside = [path.with_name(path.name + end) for end in (".json", ".sha256")] if path.suffix.lower() == ".csv" else []
    return [file_of(path, name, main) for name in names] + beside


def earlier(path: Path) -> list[Path]:
    """The files of the Sextant recording that has this name already, which a new one replaces."""
    if path.suffix.lower() not in SEVERAL:
        return [path] if path.exists() else []
    try:
        source = open_source(path)
    except UserError:
        return []
    return source.paths if source.metadata else []


def _refuse_others(path: Path) -> None:
    """What is no file, and files that are compressed as a whole."""
    if not path.exists():
        return  # the group of the name is not recorded, another one is
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    with path.open("rb") as file:
        begin = file.read(max(map(len, COMPRESSED)))
    for magic, program in COMPRESSED.items():
        if begin.startswith(magic):
            raise UserError(f"{path} is compressed: unpack it with {program} first.")


def open_source(path: Path) -> Source:
    check(path)
    _, _, module, name = _FORMATS[path.suffix.lower()]
    if not path.exists() and not any(path.parent.glob(f"{path.stem}.*{path.suffix}")):
        raise UserError(f"{path} does not exist.")
    try:
        _refuse_others(path)
        return CheckedSource(path, getattr(import_module(module, __package__), name)(path))
    except OSError as error:
        raise unreadable(path, error, "cannot be read") from None
