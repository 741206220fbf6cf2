"""The project's programs, and one of them as a process."""

import os
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Self

from sextant_py.paths import ROOT


def program(name: str) -> Path:
    """A program of the project, from the directory that SEXTANT_BIN names or else from a preset's build."""
    places = [Path(os.environ["SEXTANT_BIN"])] if "SEXTANT_BIN" in os.environ else []
    places += [ROOT / "build" / preset / "apps" for preset in ("dev", "release")] if not places else []
    for place in places:
        if (place / name).is_file():
            return place / name
    raise FileNotFoundError(f"{name} is in none of {', '.join(map(str, places))}; SEXTANT_BIN names its directory")


def modules_called(name: str) -> list[str]:
    """The modules of that name in scripts/sextant_py and in the folders of scripts/studies."""
    scripts = ROOT / "scripts"
    folders = [scripts / "sextant_py", *sorted(path for path in (scripts / "studies").iterdir() if path.is_dir())]
    found = [folder / name for folder in folders]
    found = [file for file in found if file.with_suffix(".py").is_file() or (file / "__main__.py").is_file()]
    return [".".join(file.relative_to(scripts).parts) for file in found]


def overrides(settings: Iterable[str]) -> list[str]:
    """key=value…, as the programs take them."""
    return [word for setting in settings for word in ("--set", setting)]


class ProgramProcess:
    """A program that runs beside the test; a context that ends it whatever happened."""

    def __init__(self, command: list[str | Path], output: Path, **options: object) -> None:
        """What it says goes to the file; the options are those of Popen."""
        self.command = command
        self._output = output
        self._options = options
        self._process: subprocess.Popen | None = None

    def __enter__(self) -> Self:
        with self._output.open("wb") as output:
            places = {"stdin": subprocess.DEVNULL, "stdout": output, "stderr": output}
            self._process = subprocess.Popen(self.command, **{**places, **self._options})
        return self

    def __exit__(self, *_: object) -> None:
        if self.is_running():
            self._process.terminate()
            try:
                self._process.wait(5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def is_running(self) -> bool:
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        return self._process.pid

    def send_signal(self, which: int) -> None:
        self._process.send_signal(which)

    def wait(self, timeout_s: float) -> int:
        """The exit status."""
        return self._process.wait(timeout_s)

    def text(self) -> str:
        """What it has said so far."""
        return self._output.read_text(encoding="utf-8")
