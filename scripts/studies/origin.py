"""Of a measurement: machine, date, commit and load."""

import os
import platform
import re
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT


@dataclass(frozen=True)
class Origin:
    processor: str
    cores: int
    system: str  # kernel and its release
    date: str  # UTC
    commit: str
    clean: bool  # no tracked file differed from the commit
    load: float  # load average of a minute at the start

    @staticmethod
    def now() -> "Origin":
        return Origin(
            processor(),
            os.cpu_count() or 1,
            f"{platform.system()} {platform.release()}",
            f"{datetime.now(UTC):%Y-%m-%d %H:%M}",
            git("rev-parse", "--short=10", "HEAD"),
            not git("status", "--porcelain", "--untracked-files=no"),
            round(os.getloadavg()[0], 2),
        )

    @property
    def text(self) -> str:
        tree = "" if self.clean else " with changes that are not committed"
        return (
            f"{self.processor}, {self.cores} cores, {self.system}; {self.date} UTC; commit {self.commit}{tree};"
            f" load average at the start {self.load:.2f}."
        )


def processor() -> str:
    """Its model, as the kernel names it."""
    cpuinfo = Path("/proc/cpuinfo")
    text = cpuinfo.read_text(encoding="utf-8") if cpuinfo.exists() else ""
    found = re.search(r"^model name\s*: (.*)$", text, re.MULTILINE)
    return " ".join(found[1].split()) if found else platform.processor() or platform.machine()


def git(*words: str) -> str:
    try:
        done = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True)
    except OSError as error:
        raise UserError(f"git cannot be run: {error.strerror}.") from error
    if done.returncode != 0:
        raise UserError(f"git {words[0]} failed: {done.stderr.strip()}.")
    return done.stdout.strip()
