"""Measures the torque that the drive delivers over speed, torque and wrong parameters, and writes docs/torque_map."""

import argparse
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sextant_py import mil_program
from sextant_py.errors import UserError, run
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, parser_of

from studies import json_file
from studies.command import made

from . import counts as torque_map_counts
from . import drive as torque_map_drive
from . import file as torque_map_file
from . import honest, page, points
from . import measure as torque_map_measure
from .points import Conditions
from .results import FAILED, MEANING, SILENT, Results
from .run import Lab
from .scale import Scale

PROGRAM = "torque_map"
PAGE = ROOT / "docs" / "torque_map"
RESULTS = Path(__file__).parent
EXAMPLES = """examples:
  scripts/torque_map                  the map of configs/ecu.toml, then docs/torque_map and the counts of docs/torque.md
  scripts/torque_map --quick          a handful of points, printed
  scripts/torque_map --full           the whole factorial, into out/torque_map; no page
  scripts/torque_map --drive paper    the paper's drive, with which the page compares
  scripts/torque_map --drive foc      the drive of configs/ecu_foc.toml
  scripts/torque_map --honest         the drive of configs/ecu_honest.toml, told what identify finds on its plant,
                                      then docs/torque_map/honest.md
  scripts/torque_map my.toml          any drive: a file of sextant-ecu or sextant-mil, into out/torque_map; no page
  scripts/torque_map my.toml --quick  a handful of its points, printed
  scripts/torque_map --page           no runs: the same again from paper.json, shipped.json and foc.json

Interrupted with Ctrl-C, the same command goes on where it stopped, with the same sextant-mil and configuration; records
are kept in out/torque_map. Exit status: 0 when every point ran and, but for the drive "paper", none was silently wrong,
1 when one was, 130 when interrupted."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        PROGRAM, "Measures the torque that the drive delivers over speed, torque and wrong parameters.", EXAMPLES
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="a handful of points, no page")
    size.add_argument("--full", action="store_true", help="every combination of the factors, no page")
    size.add_argument("--page", action="store_true", help="pictures and page from the results that are there")
    parser.add_argument("--honest", action="store_true", help="on a plant with the errors of a real one")
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE", help="the drive of this file, no page")
    parser.add_argument("--drive", choices=torque_map_drive.DRIVES, help="default: shipped")
    parser.add_argument("--out", type=Path, metavar="DIR", help="results, pictures, page (default: docs/torque_map)")
    add_runs(parser)
    parser.add_argument("--restart", action="store_true", help="discard the records that are there")
    options = parser.parse_args(arguments)
    if options.file and (options.drive or options.page):
        parser.error(f"FILE: {options.file} is a drive of its own; leave --drive and --page out")
    if options.honest and (options.file or options.drive or options.quick or options.full):
        parser.error("--honest: drive and points are its own; leave FILE, --drive, --quick and --full out")
    options.drive = options.drive or "shipped"
    options.is_of_page = not (options.quick or options.full or options.file)
    options.results = options.out or (RESULTS if options.is_of_page else OUT / "torque_map")
    options.out = options.out or (PAGE if options.is_of_page else OUT / "torque_map")
    return options


def chosen(options: argparse.Namespace, scale: Scale) -> tuple[list[Conditions], list[float], list[float]]:
    if options.quick:
        return points.quick_sets(), [*scale.quick_speeds], [*scale.quick_torques]
    return points.full_sets() if options.full else points.default_sets(), [*scale.speeds], [*scale.torques]


def measure(options: argparse.Namespace) -> Results:
    mil, work = mil_program.find(options.mil), made(OUT / PROGRAM)
    if options.file:
        drive, why = torque_map_file.load(options.file, mil, work), "no scenario has it"
    else:
        drive, why = torque_map_drive.load(options.drive, mil, work), "this sextant-mil does not know it"
    for key in drive.left_out:
        print(f"torque_map: {key} is left out: {why}", file=sys.stderr)
    sets, speeds, torques = chosen(options, drive.scale)
    if missing := {one.sensors for one in sets if not drive.has_sensors(one.sensors)}:
        sets = [one for one in sets if one.sensors not in missing]
        print("torque_map: sensors with errors are left out: this sextant-mil does not know them", file=sys.stderr)
        drive.left_out.append("sensors")
    lab = Lab(mil, drive, work)
    results = torque_map_measure.measured(lab, sets, speeds, torques, options.jobs, options.restart)
    if not options.quick:
        results.capability = torque_map_measure.capability(lab, speeds)
    return results


def report(results: Results) -> int:
    counts = results.counts
    for letter, meaning in MEANING.items():
        if counts[letter]:
            print(f"{counts[letter]:7} {meaning}")
    for one in results.maps:
        for where, silent_ms in list(one.silent_ms.items())[:3]:
            speed, torque = where.split("/")
            print(f"        {one.conditions.label}: {speed} rad/s, {torque} N·m: wrong for {silent_ms:g} ms")
    wrong = counts[FAILED] + (counts[SILENT] if results.drive != "paper" else 0)
    return 1 if wrong else 0


def run_minutes() -> tuple[float, float]:
    """Elapsed, and processor time of the runs that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() / 60, (children.ru_utime + children.ru_stime) / 60


@contextmanager
def timed(label: str) -> Iterator[None]:
    """Says how long the runs took."""
    before = run_minutes()
    yield
    elapsed, processor = (after - then for after, then in zip(run_minutes(), before, strict=True))
    print(f"torque_map: {label}: {elapsed:.3g} minutes, {processor:.3g} minutes of processor time")


def of_the_honest_plant(options: argparse.Namespace) -> int:
    """Map and page of the drive on a plant with the errors of a real one."""
    status = 0
    if not options.page:
        with timed("honest plant"):
            found = honest.measure(mil_program.find(options.mil), made(OUT / PROGRAM), options.jobs, options.restart)
        for results in found:
            json_file.write(options.results / f"{results.drive}.json", results)
            status |= report(results)
    maps = {name: results_in(options.results, name) for name in honest.NAMES}
    print(*honest.write(maps, options.out), sep="\n")
    return status


def results_in(directory: Path, name: str) -> Results:
    return json_file.read(directory / f"{name}.json", Results, PROGRAM)


def results_of_drives(directory: Path) -> dict[str, Results]:
    """Those of every drive that was measured; the page needs those it compares."""
    found = {}
    for name in torque_map_drive.DRIVES:
        file = directory / f"{name}.json"
        if file.is_file():
            found[name] = results_in(directory, name)
        elif name in ("paper", torque_map_drive.GUARANTEED):
            raise UserError(f"{file} is missing; scripts/torque_map --drive {name} measures it.")
    return found


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    made(options.out)
    if options.honest:
        return of_the_honest_plant(options)
    status = 0
    if not options.page:
        with timed(options.file.name if options.file else torque_map_drive.DRIVES[options.drive][0]):
            results = measure(options)
        suffix = "_quick" if options.quick else "_full" if options.full else ""
        file = options.results / f"{results.drive}{suffix}.json"
        json_file.write(file, results)
        status = report(results)
        print(file)
    if options.page or (options.is_of_page and options.drive != "paper"):
        maps = results_of_drives(options.results)
        written = page.write(maps, options.out)
        if options.out.resolve() == PAGE:
            written.append(torque_map_counts.write(maps[torque_map_drive.GUARANTEED]))
        print(*written, sep="\n")
    return status


if __name__ == "__main__":
    run(PROGRAM, main)
