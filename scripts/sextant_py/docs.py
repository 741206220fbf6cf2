"""Builds the documentation as a site of files that open from the disk, without a network; or serves it."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from . import vendor
from .errors import UserError, run
from .paths import ROOT
from .program_arguments import parser_of

DEFAULT = ROOT / "out" / "site"

EXAMPLES = """examples:
  scripts/docs                       builds out/site; out/site/index.html is the first page
  scripts/docs --out /tmp/site
  scripts/docs --serve               at http://127.0.0.1:8000, and again at every change of docs/

A link that leads nowhere ends the build with exit status 1."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("docs", __doc__, EXAMPLES)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--out", type=Path, metavar="DIR", help="where to build it (default: out/site)")
    what.add_argument("--serve", action="store_true", help="build it in memory and serve it until Ctrl-C")
    parser.add_argument("--address", default="127.0.0.1:8000", metavar="HOST:PORT", help="of --serve")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    config = ROOT / "mkdocs.yml"
    if not config.is_file():
        raise UserError("the site is built in a checkout, which has mkdocs.yml; the installed package has none.")
    vendor.need("the site", ROOT / "scripts" / "sextant_py" / "site" / "vendor")
    # What MkDocs, which is pinned, says of its next major version is no matter of these pages.
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "scripts"), "NO_MKDOCS_2_WARNING": "1"}
    mkdocs = [sys.executable, "-m", "mkdocs"]
    if options.serve:
        command = [*mkdocs, "serve", "--config-file", str(config), "--dev-addr", options.address]
        return subprocess.run(command, env=environment, check=False).returncode
    out = (options.out or DEFAULT).resolve()
    # With --quiet MkDocs would not count its warnings, so that --strict had no effect.
    command = [*mkdocs, "build", "--strict", "--config-file", str(config), "--site-dir", str(out)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line and not line.startswith("INFO")]
        print("\n".join(said), file=sys.stderr)
        raise UserError(f"the site {out} is not complete; the lines above say why.")
    print(out / "index.html")
    return 0


if __name__ == "__main__":
    run("docs", main)
