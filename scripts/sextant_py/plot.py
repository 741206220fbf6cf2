"""Draws traces and recordings: signals over time, spectra, loci and the layouts of the paper, as PNG or HTML."""

import argparse
import sys
from pathlib import Path

from .errors import UserError, run
from .program_arguments import add_span, parser_of
from .recording.formats import SUFFIXES
from .signal_file import SignalFile

PICTURES = (".png", ".svg", ".pdf")
WINDOWS = ("hann", "flattop", "blackmanharris", "boxcar")  # of a spectrum

EXAMPLES = """examples:
  scripts/plot out/run/trace.h5                               the overview, to out/run/trace.png
  scripts/plot out/a/trace.h5 out/b/trace.h5                  two runs over each other
  scripts/plot out/run/trace.h5 torque 'i_?_a' -o out/x.html  these signals, interactive, without a network
  scripts/plot out/run/trace.h5 --list                        the signals of a file
  scripts/plot out/run/trace.h5 --from 0.2 --to 0.4 --spectrum plant/torque_nm i_a_a
  scripts/plot out/run/trace.h5 --locus flux
  scripts/plot out/run/trace.h5 --figure 13                   as Figure 13 of the paper; --figure list names all

A SIGNAL is a name of --list, a pattern, or a quantity: "torque" is torque_mean_nm with the band from torque_min_nm to
torque_max_nm. Signals of one unit share a panel. Without SIGNAL the units and names of the signals decide. The ending
of the output decides between a picture (.png, .svg, .pdf) and a page (.html). docs/plots.md has all of it."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("plot", __doc__, EXAMPLES)
    endings = ", ".join(SUFFIXES)
    parser.add_argument("words", nargs="*", metavar="FILE|SIGNAL", help=f"files ({endings}) and signals of them")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="picture or page to write (default: FILE.png)"
    )
    add_span(parser)
    parser.add_argument("--title", help="heading (default: of the run or the file)")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--list", action="store_true", help="print the signals of the files and leave")
    what.add_argument("--spectrum", action="store_true", help="amplitudes over frequency (default: torque, currents)")
    what.add_argument("--locus", choices=("flux", "current"), help="the path in the α–β plane")
    what.add_argument("--figure", metavar="N", help="the layout of the paper's Figure N, or list")
    parser.add_argument(
        "--window",
        choices=WINDOWS,
        default="hann",
        help="of a spectrum (default: hann; flattop has the most exact amplitudes)",
    )
    options = parser.parse_intermixed_args(arguments)
    options.files = [Path(word) for word in options.words if is_file(word)]
    options.signals = [word for word in options.words if not is_file(word)]
    if not options.files and options.figure != "list":
        unknown = f', and "{options.words[0]}" is none' if options.words else ""
        parser.error(f"expected a file that ends in {endings}{unknown}")
    return options


def is_file(word: str) -> bool:
    """A signal has no ending of a file, and no file of its name lies here."""
    return Path(word).suffix.lower() in SUFFIXES or Path(word).is_file()


def print_signals(path: Path) -> None:
    """The signals of a file by their groups, with the span of each group."""
    found = SignalFile(path)
    print(path)
    for name, rows in found.groups.items():
        if not rows.count:
            print(f"{name}: no samples")
            continue
        time_s = rows.time_s
        print(f"{name}: {len(time_s)} samples from {time_s[0]:g} s to {time_s[-1]:g} s")
        columns = [entry for entry in found.columns(name) if entry[1].name != "t_ns"]
        width = max((len(full) for full, _ in columns), default=0)
        for full, column in columns:
            print(f"  {full:<{width}}  {column.unit:<6} {column.text}".rstrip())


def tell_cuts(sentences: list[str | None]) -> None:
    for sentence in filter(None, sentences):
        print(f"plot: {sentence}", file=sys.stderr)


def perform(options: argparse.Namespace, output: Path) -> None:
    is_page = output.suffix.lower() == ".html"
    from .plots import series

    files = series.load(options.files, options.begin_s, options.end_s)
    tell_cuts([file.cut for file in files])
    title = options.title or " and ".join(file.label for file in files)
    if options.figure:
        from .plots import layouts

        if is_page:
            raise UserError(f"--figure draws a picture ({', '.join(PICTURES)}), not the page {output}.")
        layouts.draw(files, options.figure, output)
    elif options.locus:
        from .plots import locus

        (locus.draw_html if is_page else locus.draw_png)(
            locus.compute(files, options.locus), options.locus, title, output
        )
    elif options.spectrum:
        from .plots import spectrum

        spectra = spectrum.compute(files, options.signals, options.window)
        (spectrum.draw_html if is_page else spectrum.draw_png)(spectra, title, output)
    else:
        from .plots import html, marks, overview, panels, png

        # A trace or telemetry has an overview; a capture of control periods has other signals.
        alone = len(files) == 1 and not options.signals and not is_page and files[0].has_telemetry
        arranged = overview.arrange(files[0]) if alone else panels.arrange(files, options.signals)
        (html if is_page else png).draw(arranged, title, output, marks.of(files))


def default_output(options: argparse.Namespace) -> Path:
    """Beside the first file, with the kind of the picture in its name unless it is one over time."""
    kind = ".spectrum" if options.spectrum else ""
    kind = f".{options.locus}_locus" if options.locus else kind
    kind = f".figure_{options.figure}" if options.figure else kind
    return options.files[0].with_suffix(f"{kind}.png")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if options.figure == "list":
        from .plots import layouts

        print(layouts.listed())
        return 0
    if options.list:
        for path in options.files:
            print_signals(path)
        return 0
    output = options.output or default_output(options)
    if output.suffix.lower() not in (*PICTURES, ".html"):
        raise UserError(f'-o {output}: expected the ending {", ".join(PICTURES)} or .html, got "{output.suffix}".')
    perform(options, output)
    print(output)
    return 0


if __name__ == "__main__":
    run("plot", main)
