"""Finished points of a sweep on disk: one line of JSON each, so that an interrupted sweep goes on where it stopped."""

import fcntl
import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

from .append_file import AppendFile
from .errors import UserError
from .sweep_file import Sweep
from .sweep_point import EXPECT_FAILED, FAILED, OK

FORMAT = 1


def digest(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


class SweepStore:
    """A directory with sweep.json, what is swept, and points.jsonl, what is finished. One process at a time has it."""

    def __init__(self, directory: Path, sweep: Sweep, configuration: str, program: str) -> None:
        """configuration: the scenario's in force; program: the fingerprint of sextant-mil."""
        self.directory = directory
        self.records: dict[int, dict] = {}
        self._sweep = sweep
        self._identity = {
            "the sweep file": digest([str(sweep.scenario), sweep.fixed, sweep.varied, sweep.seed]),
            "the scenario or a file that it names": digest(configuration),
            "the program sextant-mil": program,
        }
        self._log: AppendFile | None = None
        self._lock = self._take_lock()

    @property
    def state_file(self) -> Path:
        return self.directory / "sweep.json"

    @property
    def points_file(self) -> Path:
        return self.directory / "points.jsonl"

    def _take_lock(self) -> TextIO:
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            lock = (self.directory / ".lock").open("w")
        except OSError as error:
            raise UserError(f"--out: {self.directory} cannot be written: {error.strerror}.") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            raise UserError(f"another sweep runs in {self.directory}; --out names another directory.") from None
        return lock

    def open(self, restart: bool = False, retry_failed: bool = False) -> None:
        """Takes up what is finished. A sweep that is another one than before is refused, or begun anew."""
        if restart:
            self.points_file.unlink(missing_ok=True)
        elif self.state_file.exists():
            self._check_state()
            self._read_records()
        elif self.points_file.exists():
            raise UserError(f"{self.points_file} is there without sweep.json; --restart begins anew.")
        if retry_failed:
            self.records = {k: record for k, record in self.records.items() if record["status"] != FAILED}
        self._write_state()
        self._rewrite_records()
        self._log = AppendFile(self.points_file, keep=True)

    def _check_state(self) -> None:
        try:
            state = json.loads(self.state_file.read_text(encoding="utf-8"))
            count, identity = state["points"], state["identity"]
            same_points = state["format"] == FORMAT and digest(self._sweep.points[:count]) == state["points_digest"]
        except (OSError, ValueError, KeyError, TypeError):
            raise UserError(f"{self.state_file} is no state of a sweep; --restart begins anew.") from None
        # More points after the same ones are the same sweep, continued.
        changed = [what for what, known in self._identity.items() if identity.get(what) != known]
        if not same_points and "the sweep file" not in changed:
            changed.insert(0, "the sweep file")
        if changed:
            raise UserError(
                f"{' and '.join(changed)} changed since {self.directory} was begun; --restart discards the points that "
                "are finished there, --out names another directory."
            )

    def _read_records(self) -> None:
        if not self.points_file.exists():
            return
        lines = self.points_file.read_bytes().split(b"\n")
        # The last line ends in a line feed; what follows it was cut off while it was written.
        for number, line in enumerate(lines[:-1], 1):
            try:
                record = json.loads(line)
                known = 0 <= record["point"] < len(self._sweep.points) and isinstance(record["metrics"], dict)
                known &= record["status"] in (OK, EXPECT_FAILED, FAILED) and isinstance(record["reason"], str)
            except (ValueError, KeyError, TypeError):
                known = False
            if not known:
                raise UserError(f"{self.points_file}:{number}: not the record of a point; --restart begins anew.")
            self.records[record["point"]] = record

    def _write_state(self) -> None:
        sweep = self._sweep
        state = {
            "format": FORMAT,
            "name": sweep.name,
            "file": str(sweep.file.resolve()),
            "scenario": str(sweep.scenario),
            "seed": sweep.seed,
            "points": len(sweep.points),
            "points_digest": digest(sweep.points),
            "identity": self._identity,
        }
        self._replace(self.state_file, json.dumps(state, indent=2) + "\n")

    def _rewrite_records(self) -> None:
        """Without what was cut off and what is to be run once more."""
        self._replace(self.points_file, "".join(_line(record) for record in self.records.values()))

    def _replace(self, file: Path, text: str) -> None:
        part = file.with_name(file.name + ".part")
        try:
            out = AppendFile(part)
            try:
                out.append(text)
                out.sync()
            finally:
                out.close()
            part.rename(file)
        except OSError as error:
            raise _unwritable(file, error) from None

    def missing(self) -> list[int]:
        return [k for k in range(len(self._sweep.points)) if k not in self.records]

    def add(self, record: dict) -> None:
        """Keeps a point: it is on the disk when this returns."""
        if self._log is None:
            raise RuntimeError("the store is not open")
        try:
            self._log.append(_line(record))
            self.records[record["point"]] = record
            self._log.sync()
        except OSError as error:
            raise _unwritable(self.points_file, error) from None

    def count(self, status: str) -> int:
        return sum(record["status"] == status for record in self.records.values())

    def in_order(self) -> Iterable[dict]:
        return (self.records[k] for k in sorted(self.records))

    def close(self) -> None:
        if self._log is not None:
            self._log.close()
        self._lock.close()


def _unwritable(file: Path, error: OSError) -> UserError:
    return UserError(f"{file} cannot be written: {error.strerror}; the same command goes on once there is room.")


def _line(record: dict) -> str:
    return json.dumps(record, ensure_ascii=False) + "\n"
