"""Where the stages of a benchmark run: the programs they call, and the time they may take."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from .figure import Figure, NotMeasurableError
from .google import GoogleResult

NO_KERNEL = 125  # exit status of scripts/with_vcan


@dataclass(frozen=True)
class Stage:
    """A part of the benchmark. An exception from `run` fails the stage and not the others."""

    name: str  # as in --only
    title: str  # for people
    seconds: float  # it takes about so long on two processors; four times as long and a minute, and it is ended
    run: Callable[["Lab"], list[Figure]]


@dataclass
class Lab:
    """Runs programs within the time of the present stage."""

    programs: Path = ROOT / "build" / "release" / "tests" / "bench"
    out: Path = ROOT / "out" / "bench"
    deadline: float = field(default_factory=lambda: time.monotonic() + 3600.0)
    distributions: dict[str, dict[str, float]] = field(default_factory=dict)  # summaries that the page shows

    def begin(self, stage: Stage) -> None:
        self.deadline = time.monotonic() + 4.0 * stage.seconds + 60.0
        self.distributions = {}
        self.out.mkdir(parents=True, exist_ok=True)

    def run(self, *command: str | Path, accept: tuple[int, ...] = (0,)) -> str:
        """What the command writes to its standard output. accept: the exit statuses that are no failure.

        Throws UserError where it fails, and NotMeasurableError where it takes too long, where a program of the system
        is not installed, and where the command needs a kernel that cannot be had."""
        words = [str(word) for word in command]
        try:
            left = max(1.0, self.deadline - time.monotonic())
            done = subprocess.run(words, capture_output=True, text=True, timeout=left, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired as error:
            raise NotMeasurableError(f"{Path(words[0]).name} took longer than the stage may") from error
        except OSError as error:
            kind = UserError if "/" in words[0] else NotMeasurableError
            raise kind(f"{words[0]} cannot be run: {error.strerror}") from error
        if done.returncode == NO_KERNEL and any(word.endswith("/with_vcan") for word in words):
            raise NotMeasurableError(f"there is no kernel with vcan: {done.stderr.strip()[-300:]}")
        if done.returncode not in accept:
            raise UserError(f"{Path(words[0]).name} failed: {(done.stderr or done.stdout).strip()[-300:]}")
        return done.stdout

    def google(
        self, pattern: str, program: str = "sextant_bench", repetitions: int = 10, min_time: float = 0.1
    ) -> GoogleResult:
        """The benchmarks of a program that match the pattern, their repetitions in random turns."""
        self.out.mkdir(parents=True, exist_ok=True)
        file = self.out / f"{program}.json"
        file.unlink(missing_ok=True)
        self.run(
            *(self.programs / program, f"--benchmark_filter={pattern}", f"--benchmark_repetitions={repetitions}"),
            *(f"--benchmark_min_time={min_time}", "--benchmark_enable_random_interleaving=true"),
            *(f"--benchmark_out={file}", "--benchmark_out_format=json"),
        )
        text = file.read_text(encoding="utf-8") if file.exists() else ""
        return GoogleResult(json.loads(text) if text else {"benchmarks": []})  # it writes nothing where nothing matches

    def say(self, text: str) -> None:
        print(f"    {text}", file=sys.stderr, flush=True)
