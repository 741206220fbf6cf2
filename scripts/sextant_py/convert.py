"""Converts recordings and traces between HDF5, MCAP, MDF4, CSV and Parquet."""

import argparse
import sys
from pathlib import Path

from .errors import UserError, run
from .recording import formats
from .recording.copying import copy, main_of
from .recording.model import Source
from .recording.progress import Progress

EXAMPLES = """examples:
  convert run.h5 run.mf4                     for CANape and MDA
  convert trace.h5 trace.mcap                a trace of sextant-mil for Foxglove and PlotJuggler
  convert run.mcap run.csv                   run.csv, run.drive_state.csv, run.waveform.csv and so on
  convert run.mcap waveform.parquet --group waveform
  convert cut.mcap whole.mcap --truncated    what is left of a file that was cut
"""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="convert",
        description="Converts a recording of scripts/record or a trace of sextant-mil; the suffixes"
        f" {', '.join(formats.SUFFIXES)} name the formats.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("input", type=Path, metavar="IN", help="recording or trace to read")
    parser.add_argument("output", type=Path, metavar="OUT", help="file to write; an existing one is replaced")
    parser.add_argument(
        "--group", action="append", metavar="NAME", help="convert this group only (repeatable; default: all)"
    )
    parser.add_argument(
        "--truncated", action="store_true", help="a truncated IN is no failure: convert what is left, exit status 0"
    )
    return parser.parse_args(arguments)


def chosen(source: Source, path: Path, names: list[str] | None) -> list[str]:
    unknown = [name for name in names or () if name not in source.groups]
    if unknown:
        raise UserError(f"{path} has no group {unknown[0]}; it has {', '.join(source.groups)}.")
    return list(source.groups) if names is None else list(dict.fromkeys(names))


def check(source: Source, options: argparse.Namespace, names: list[str]) -> None:
    """Refuses an output that would replace a file of the input, and one that would have no row."""
    written = [*formats.files(options.output, names, main_of(names)), *formats.earlier(options.output)]
    replaced = {place.resolve() for place in written}
    for place in source.paths:
        if place.resolve() in replaced:
            raise UserError(
                f"{options.output} would replace {place}, which is to be read; the converted one needs another name."
            )
    if not any(source.rows(name) for name in names):
        reason = source.cut or f"{options.input} has no rows of {', '.join(names)}"
        raise UserError(f"{reason}; {options.output} is not written.")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    formats.check(options.output)
    source = formats.open_source(options.input)
    names = chosen(source, options.input, options.group)
    check(source, options, names)
    if source.unverified:
        print(f"convert: {source.unverified}", file=sys.stderr)
    progress = Progress()
    kept = copy(source, options.output, names, lambda share: progress.show(f"{options.output}: {share:.0%} written"))
    progress.end()
    found = {name: source.rows(name) for name in names}
    print(f"{options.output}: {', '.join(f'{kept[name]} of {found[name]} rows of {name}' for name in names)}")
    if kept != found:
        raise UserError(f"{options.output} lacks rows that {options.input} has: this is an error of convert.")
    if source.cut and options.truncated:
        print(f"convert: {source.cut}", file=sys.stderr)
    elif source.cut:
        raise UserError(f"{source.cut}. {options.output} has them; --truncated makes this a success.")
    return 0


if __name__ == "__main__":
    run("convert", main)
