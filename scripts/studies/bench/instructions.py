"""Instructions of one step of everything on the control path, against a stored baseline."""

import json
import platform
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sextant_py.errors import UserError, output_of, run
from sextant_py.paths import ROOT
from sextant_py.program_arguments import parser_of

from studies import json_file

BASELINE = ROOT / "tests" / "bench" / "instructions.json"
TOLERANCE_PERCENT = 2.0
SEED_PERCENT = 5.0

# Steps of the shorter of two runs; the longer has twice as many. Whole replays of the 192 recorded periods, and for
# the closed loop, which starts from rest, past its start.
STEPS = {"closed_loop_period_fixed": 9600, "plant_period_cvode": 960}
DEFAULT_STEPS = 1920

ACCEPT = (
    "If it is meant: scripts/check_instructions --update, and commit tests/bench/instructions.json with the reason."
)


def instructions(probe: Path, what: str, steps: int, nops: int = 0) -> int:
    """Of a whole run, by callgrind."""
    callgrind = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")
    text = output_of(*callgrind, probe, what, steps, nops, with_errors=True)
    found = re.search(r"Collected : (\d+)", text)
    if not found:
        raise UserError(f"callgrind did not say how many instructions {what} took: {text.strip()[-300:]}")
    return int(found[1])


def per_step(count: Callable[[int], int], steps: int) -> float:
    """Of one step: what the second half of a run of 2·steps adds to a run of `steps`. What starts and ends the program
    is in both."""
    return (count(2 * steps) - count(steps)) / steps


def measure(probe: Path, nops: dict[str, int] | None = None) -> dict[str, float]:
    names = output_of(probe, with_errors=True).split()

    def one(name: str) -> float:
        seed = (nops or {}).get(name, 0)
        return round(per_step(lambda n: instructions(probe, name, n, seed), STEPS.get(name, DEFAULT_STEPS)), 1)

    with ThreadPoolExecutor(2) as pool:
        return dict(zip(names, pool.map(one, names), strict=True))


def compiler_of(probe: Path) -> str:
    """The first line of what the compiler of the probe's build says of itself."""
    folder = next((p for p in probe.resolve().parents if (p / "CMakeCache.txt").exists()), None)
    if folder is None:
        raise UserError(f"{probe} lies in no build folder of CMake; build it with scripts/check_instructions.")
    cache = (folder / "CMakeCache.txt").read_text(encoding="utf-8")
    compiler = re.search(r"^CMAKE_CXX_COMPILER:\w+=(.*)$", cache, re.MULTILINE)
    # c++ and g++ are one.
    return re.sub(r"^[gc]\+\+\S* ", "g++ ", output_of(compiler[1], "--version").splitlines()[0])


def environment(probe: Path) -> dict[str, str]:
    """What the counts depend on beside the code. The C library chooses its routines by the processor."""
    flags = re.search(r"^flags\s*: (.*)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    known = flags[1].split() if flags else []
    return {
        "compiler": compiler_of(probe),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
        "processor": " ".join(flag for flag in ("avx2", "fma") if flag in known),
        "valgrind": output_of("valgrind", "--version").strip(),
    }


def judge(baseline: dict[str, float], now: dict[str, float], tolerance: float = TOLERANCE_PERCENT) -> list[str]:
    """One sentence for each count that left its place by more than the tolerance [%], came or went."""
    found = []
    for name, before in baseline.items():
        if name not in now:
            found.append(f"{name} is in the baseline and no longer counted.")
            continue
        change = 100.0 * (now[name] / before - 1.0)
        if abs(change) > tolerance:
            verb = "grew" if change > 0 else "fell"
            found.append(f"{name} {verb} from {before:g} to {now[name]:g} instructions a step ({change:+.1f} %).")
    found.extend(f"{name} is new and not in the baseline." for name in now if name not in baseline)
    return found


def differences(stored: dict[str, str], here: dict[str, str]) -> list[str]:
    keys = sorted({*stored, *here})
    return [f"{k}: {stored.get(k)} there, {here.get(k)} here" for k in keys if stored.get(k) != here.get(k)]


def print_table(now: dict[str, float], baseline: dict[str, float]) -> None:
    for name, value in now.items():
        change = f"{100.0 * (value / baseline[name] - 1.0):+7.2f} %" if name in baseline else ""
        print(f"{name:<28} {value:>10.1f} instructions a step  {change}")


def check(probe: Path, file: Path) -> int:
    stored = json_file.read(file, dict[str, dict], "check_instructions --update")
    baseline = stored["instructions_per_step"]
    now = measure(probe)
    print_table(now, baseline)
    other = differences(stored["environment"], environment(probe))
    if other:
        print(f"!!! NOT TESTED: instruction counts; the baseline is of another machine ({'; '.join(other)}) !!!")
        return 0
    found = judge(baseline, now)
    for sentence in found:
        print(f"check_instructions: {sentence}")
    if found:
        print(f"check_instructions: {ACCEPT}")
        return 1
    print(f"check_instructions: {len(now)} counts within {TOLERANCE_PERCENT:g} % of the baseline")
    return 0


def update(probe: Path, file: Path) -> int:
    now = measure(probe)
    print_table(now, json.loads(file.read_text(encoding="utf-8"))["instructions_per_step"] if file.exists() else {})
    text = json.dumps({"environment": environment(probe), "instructions_per_step": now}, indent=2)
    file.write_text(text + "\n", encoding="utf-8")
    print(f"check_instructions: {len(now)} counts written")
    return 0


def self_test(probe: Path) -> int:
    """Each count with 5 % more instructions must be found, and the same program twice must not."""
    clean = measure(probe)
    if judge(clean, measure(probe)):
        raise UserError("two counts of the same program differ; instructions cannot be judged here.")
    seeded = measure(probe, {name: max(2, round(value * SEED_PERCENT / 100)) for name, value in clean.items()})
    print_table(seeded, clean)
    missed = [name for name in clean if not judge({name: clean[name]}, {name: seeded[name]})]
    if missed:
        raise UserError(f"a slow-down of {SEED_PERCENT:g} % was not found in {', '.join(missed)}.")
    print(f"found: {SEED_PERCENT:g} % more instructions in each of {len(clean)} counts")
    return 0


def main(argv: list[str]) -> int:
    parser = parser_of(
        "check_instructions", __doc__, "examples:\n  scripts/check_instructions\n  scripts/check_instructions --update"
    )
    parser.add_argument("probe", type=Path, help="sextant_instruction_probe of the release")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--baseline", type=Path, default=BASELINE)
    arguments = parser.parse_args(argv)
    if arguments.self_test:
        return self_test(arguments.probe)
    return (update if arguments.update else check)(arguments.probe, arguments.baseline)


if __name__ == "__main__":
    run("check_instructions", main)
