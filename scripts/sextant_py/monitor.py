"""The terminal monitor: what the drives of a DDS domain are doing, in place, or why no samples arrive."""

import argparse
import enum
import json
import math
import time
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from .dds import Drive, Telemetry
from .drive_view import DriveView
from .errors import EndedError, run
from .program_arguments import parser_of, positive_seconds

REFRESH_S = 0.1
LINE_EVERY_S = 1.0
PATIENCE_S = 2.0

EXAMPLES = """examples:
  scripts/monitor                      every drive in place, with the course of torque and speed; Ctrl-C ends it
  scripts/monitor | tee drive.log      one line a second
  scripts/monitor --once --domain 7    what is there in another DDS domain
  scripts/monitor --json | jq '.drives[].telemetry.torque_mean_nm'

Colours are off where the output is no terminal or NO_COLOR is set. Exit status: 1 when no sample arrived."""


def plain(sample: Any) -> dict | None:
    """A sample as plain values; states by name."""
    if sample is None:
        return None
    values = {name: getattr(sample, name) for name in sample.__annotations__}
    return {name: value.name if isinstance(value, enum.Enum) else value for name, value in values.items()}


def as_dict(telemetry: Telemetry) -> dict:
    """All that is known, for scripts."""
    drives = [
        {
            "drive_id": drive.drive_id,
            "received": drive.received,
            "telemetry": plain(drive.telemetry),
            "state": plain(drive.state),
            "statistics": plain(drive.statistics),
        }
        for drive in telemetry.drives.values()
    ]
    return {"drives": drives, "problems": telemetry.problems()}


class Monitor:
    """Polls the telemetry and shows it until a time, or once."""

    def __init__(self, telemetry: Telemetry, console: Console) -> None:
        self._telemetry = telemetry
        self._console = console
        self._views: dict[int, DriveView] = {}
        self._began_s = time.monotonic()

    def _problems(self) -> list[str]:
        """Discovery takes a moment; before that silence means nothing."""
        return self._telemetry.problems() if time.monotonic() - self._began_s > PATIENCE_S else []

    def _view(self, drive: Drive) -> DriveView:
        return self._views.setdefault(drive.drive_id, DriveView())

    def screen(self) -> Group:
        drives = sorted(self._telemetry.drives.values(), key=lambda drive: drive.drive_id)
        parts: list[Any] = [self._view(drive).panel(drive, self._console.width) for drive in drives]
        parts += [Text(problem, style="yellow") for problem in self._problems()]
        return Group(*parts) if parts else Group(Text("listening …", style="dim"))

    def lines(self) -> list[str]:
        drives = sorted(self._telemetry.drives.values(), key=lambda drive: drive.drive_id)
        return [self._view(drive).line(drive) for drive in drives] + self._problems()

    def show_in_place(self, end_s: float) -> None:
        with Live(self.screen(), console=self._console, refresh_per_second=10, transient=False) as live:
            while time.monotonic() < end_s:
                self._telemetry.poll()
                live.update(self.screen())
                time.sleep(REFRESH_S)

    def print_lines(self, end_s: float) -> None:
        due_s = time.monotonic() + LINE_EVERY_S
        while time.monotonic() < end_s:
            self._telemetry.poll()
            if time.monotonic() >= due_s:
                due_s += LINE_EVERY_S
                for line in self.lines():
                    print(line, flush=True)
            time.sleep(REFRESH_S)

    def wait_for_all(self, end_s: float) -> None:
        """Until every topic has a sample, or the time is over."""
        while time.monotonic() < end_s:
            self._telemetry.poll()
            if self._telemetry.drives and not self._telemetry.problems():
                return
            time.sleep(0.02)


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "monitor", "Shows the telemetry of the drives that are on the network; Ctrl-C ends it.", EXAMPLES
    )
    parser.add_argument("--domain", type=int, default=0, help="DDS domain (default: 0)")
    parser.add_argument("--duration", type=positive_seconds, metavar="S", help="end after so long")
    parser.add_argument("--once", action="store_true", help="show what is there, once, and end; fail if it is nothing")
    parser.add_argument("--json", action="store_true", help="as --once, in JSON")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    telemetry = Telemetry(options.domain)
    console = Console()
    monitor = Monitor(telemetry, console)
    if options.once or options.json:
        monitor.wait_for_all(time.monotonic() + (options.duration or 3.0))
        if options.json:
            print(json.dumps(as_dict(telemetry), indent=2))
        elif telemetry.drives:
            console.print(monitor.screen())
    else:
        end_s = time.monotonic() + (options.duration or math.inf)
        try:
            if console.is_terminal and not console.is_dumb_terminal:
                monitor.show_in_place(end_s)
            else:
                monitor.print_lines(end_s)
        except KeyboardInterrupt:
            pass
    if telemetry.stream.samples == 0:
        raise EndedError(" ".join(telemetry.problems()) or "no telemetry arrived.")
    return 0


if __name__ == "__main__":
    run("monitor", main)
