"""Line coverage by file from gcovr's JSON. A line counts once, however many instantiations of a template it has, and is
covered when one of them ran: gcov also lists instantiations that the linker dropped, which never run."""

import argparse
import json
import sys
from pathlib import Path


def lines_by_file(report: dict) -> dict[str, dict[int, int]]:
    """For each file its lines with the largest count of any instantiation."""
    files: dict[str, dict[int, int]] = {}
    for file in report["files"]:
        counts = files.setdefault(file["file"], {})
        for line in file["lines"]:
            if not line.get("gcovr/noncode") and not line.get("gcovr/excluded"):
                number = line["line_number"]
                counts[number] = max(counts.get(number, 0), line["count"])
    return files


def main() -> int:
    parser = argparse.ArgumentParser(prog="coverage", description=__doc__)
    parser.add_argument("file", help="gcovr's JSON")
    parser.add_argument("--least", type=float, required=True, help="exit status 1 below so many per cent")
    arguments = parser.parse_args()
    total = covered = 0
    for name, counts in sorted(lines_by_file(json.loads(Path(arguments.file).read_text(encoding="utf-8"))).items()):
        missing = [str(number) for number, count in sorted(counts.items()) if count == 0]
        total += len(counts)
        covered += len(counts) - len(missing)
        share = 100 * (len(counts) - len(missing)) / max(len(counts), 1)
        print(f"{name:<56} {len(counts):>5} {share:>6.1f} %  {','.join(missing)}")
    if total == 0:
        print("coverage: the report has no lines; did the tests run?", file=sys.stderr)
        return 1
    share = 100 * covered / total
    print(f"{'TOTAL':<56} {total:>5} {share:>6.1f} %")
    return 0 if share >= arguments.least else 1


if __name__ == "__main__":
    sys.exit(main())
