"""The drive on a Cortex-M4F: builds firmware, runs golden inputs under QEMU, judges and counts."""

import argparse
import os
import re
import subprocess
from dataclasses import asdict
from pathlib import Path

import numpy as np
from sextant_py.errors import UserError, output_of, run
from sextant_py.paths import ROOT

from . import firmware_image, golden, page

BUILD = ROOT / "build" / "cortex-m"
RUNS = {"immediate": 0, "delayed": 1}  # actuation delay [periods]
MACHINE = "netduinoplus2"  # QEMU's STM32F405, 168 MHz
CLOCK_MHZ = 168.0
TICK_SHIFT = 8  # the emulator's time goes on by 2^8 ns an instruction, ...
TICKS_PER_INSTRUCTION = 2**TICK_SHIFT * CLOCK_MHZ * 1e-3  # ... which is many ticks of the timer
DOUBLE_TOLERANCES = 5.0  # how far float may be from double, in tolerances between two machines with float
DOUBLE_OTHERS = 2  # periods: while the machine is magnetised, the nearest of two vectors hangs on the rounding of float
ALLOWED_GROWTH = 1.02
ADVICE = "; if that is meant, scripts/check_cortex_m --update"
SEEDS = {
    "promotion": r"\[-Werror=double-promotion\]",
    "exception": r"exception handling disabled",
    "heap": r"undefined reference to `_sbrk'",
    "library_exception": r"undefined reference to `_exit'",
}


def build(*targets: str) -> subprocess.CompletedProcess:
    command = ["cmake", "--build", BUILD, *(("--target", *targets) if targets else ())]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def build_firmware() -> None:
    output_of("arm-none-eabi-g++", "--version")
    toolchain = ROOT / "cmake" / "toolchains" / "cortex-m4f.cmake"
    source = ROOT / "tests" / "cortex_m" / "firmware"
    output_of("cmake", "-S", source, "-B", BUILD, "-G", "Ninja", "--toolchain", toolchain)
    built = build()
    if built.returncode:
        raise UserError(f"the firmware does not build:\n{built.stdout[-4000:]}")


def emulate(image: str, *arguments: str, options: tuple[str, ...]) -> str:
    """Runs an image to its end, in the folder of the build; what it printed."""
    words = ",".join(["enable=on", "target=native", *(f"arg={word}" for word in (image, *arguments))])
    command = ["qemu-system-arm", "-M", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"]
    command += [*options, "-semihosting-config", words, "-kernel", f"{image}.elf"]
    try:
        done = subprocess.run(command, cwd=BUILD, capture_output=True, text=True, timeout=60, check=False)
    except FileNotFoundError:
        raise UserError("qemu-system-arm is missing; scripts/setup --gates installs it.") from None
    except subprocess.TimeoutExpired:
        raise UserError(f"{image} does not come to its end under QEMU.") from None
    said = done.stdout + done.stderr
    if done.returncode:
        raise UserError(f"{image} fails under QEMU: {said.strip() or 'it says nothing'}")
    return said


class GoldenRun:
    """One recorded run of the drive, and what host and microcontroller make of it."""

    def __init__(self, host: Path, name: str) -> None:
        self._host = host
        self._name = name
        self.inputs = f"{name}.inputs"
        self._call(self.inputs, "--delay", str(RUNS[name]))
        self.periods = int(np.fromfile(BUILD / self.inputs, golden.SETUP, 1)["periods"][0])
        self.reference = self.replay("float")
        self.variants = [
            self.replay("float", f"--shift-{what}={sign * by}")
            for what, by in golden.SHIFTS.items()
            for sign in (1, -1)
        ]

    def _call(self, *words: str) -> None:
        subprocess.run([self._host, *words], cwd=BUILD, check=True)

    def replay(self, scalar: str, *shift: str) -> np.ndarray:
        outputs = f"{self._name}.{scalar}.outputs"
        self._call(self.inputs, outputs, "--scalar", scalar, *shift)
        return golden.load_outputs(BUILD / outputs, self.periods)

    def on_target(self, image: str) -> tuple[np.ndarray, golden.Costs]:
        outputs, costs = f"{self._name}.{image}.outputs", f"{self._name}.{image}.costs"
        emulate(image, self.inputs, outputs, costs, options=("-icount", f"shift={TICK_SHIFT}"))
        return (
            golden.load_outputs(BUILD / outputs, self.periods),
            golden.load_costs(BUILD / costs, TICKS_PER_INSTRUCTION),
        )

    def edge(self) -> int:
        """Periods in which a shift of a threshold by its tolerance changes a decision."""
        return int(np.any([golden.other_decision(self.reference, v) for v in self.variants], axis=0).sum())


def spread(instructions: np.ndarray) -> dict[str, float]:
    return {"mean": round(float(instructions.mean()), 1), "max": int(instructions.max())}


def instructions(costs: golden.Costs) -> dict[str, dict]:
    driven = costs.driven
    return {
        "drive_step": spread(costs.drive),
        "drive_step_driven": spread(costs.drive[driven]),
        "controller_step": spread(costs.controller),
        "controller_step_driven": spread(costs.controller[driven]),
        "plant_period_driven": spread(costs.plant[driven]),
        "plant_period_gates_off": spread(costs.plant[~driven]),
    }


def comparison(found: golden.Comparison) -> dict:
    kept = asdict(found)
    kept.pop("problems")
    kept["largest"] = {name: float(f"{value:.2g}") for name, value in found.largest.items()}
    return kept


def measure_run(golden_run: GoldenRun, problems: list[str], name: str) -> dict:
    outputs, costs = golden_run.on_target("golden")
    unfused, _ = golden_run.on_target("golden_unfused")
    pairs = {"target": outputs, "target_unfused": unfused, "host_double": golden_run.replay("double")}
    found = {}
    for key, values in pairs.items():
        loose = (DOUBLE_TOLERANCES, DOUBLE_OTHERS) if key == "host_double" else ()
        found[key] = golden.compare(golden_run.reference, values, golden_run.variants, *loose)
    problems += [f"{name}, {key}: {text}" for key, c in found.items() for text in c.problems]
    return {
        "periods": golden_run.periods,
        "periods_on_edge": golden_run.edge(),
        "against_host_float": {key: comparison(c) for key, c in found.items()},
        "instructions": instructions(costs),
    }


def methods(inputs: str) -> dict[str, dict[str, float]]:
    """Instructions of a step of each control method, gates driven, on the measurements of a golden run."""
    said = emulate("methods", inputs, "methods.costs", options=("-icount", f"shift={TICK_SHIFT}"))
    names = said.split()
    ticks = np.fromfile(BUILD / "methods.costs", "<u4").reshape(-1, len(names))
    counts = np.round(ticks[ticks.any(axis=1)] / TICKS_PER_INSTRUCTION).astype(int)
    return {name: spread(counts[:, n]) for n, name in enumerate(names)}


def stack(inputs: str) -> int:
    """The most that the stack has held: in the firmware with its interrupt, or in a golden run [B]."""
    firmware = emulate("drive_firmware_run", options=("-icount", "shift=3"))
    drive = emulate("golden_drive", inputs, "stack.outputs", "stack.costs", options=())
    found = [re.search(r"stack (\d+) bytes", said) for said in (firmware, drive)]
    if not all(found):
        raise UserError(f"an image does not say how much stack it has used: {firmware!r}, {drive!r}")
    return max(int(one[1]) for one in found)


def measure_firmware(inputs: str, problems: list[str]) -> dict:
    image = BUILD / "drive_firmware.elf"
    for checked in ("drive_firmware", "golden", "methods"):
        names = firmware_image.forbidden(BUILD / f"{checked}.elf")
        problems += [f"{checked}: {name} must not be in it" for name in names]
    depends = output_of("ninja", "-C", BUILD, "-t", "deps", "CMakeFiles/drive_firmware.dir/drive_firmware.cpp.obj")
    if "sextant/drive/drive.hpp" not in depends:
        raise UserError("what the firmware includes is not known: build/cortex-m has no dependencies of it.")
    if "Eigen" in depends:
        problems.append("drive_firmware: includes Eigen, which the control path does not need")
    of = firmware_image.sections(image)
    largest = firmware_image.symbols(image, demangle=True)[:10]
    return {
        "flash": firmware_image.flash(of),
        "ram": firmware_image.ram(of),
        "stack": stack(inputs),
        "sections": of,
        "largest": [{"name": s.name, "size": s.size} for s in largest],
    }


def measure(host: Path) -> tuple[dict, list[str]]:
    build_firmware()
    problems: list[str] = []
    runs = {name: GoldenRun(host, name) for name in RUNS}
    firmware = measure_firmware(runs["delayed"].inputs, problems)
    measured = {name: measure_run(r, problems, name) for name, r in runs.items()}
    version = output_of("arm-none-eabi-g++", "-dumpfullversion").strip()
    figures = {
        "compiler": f"arm-none-eabi-g++ {version} -O2",
        "processor": "Cortex-M4F",
        "firmware_bytes": firmware,
        "runs": measured,
        "methods": methods(runs["delayed"].inputs),
    }
    return figures, problems


def bounded(figures: dict) -> dict[str, float]:
    """The figures that may not grow."""
    found = {key: figures["firmware_bytes"][key] for key in ("flash", "ram", "stack")}
    for name, of_run in figures["runs"].items():
        for what, counts in of_run["instructions"].items():
            found |= {f"{name} {what} {statistic}": value for statistic, value in counts.items()}
    for name, counts in figures["methods"].items():
        found |= {f"{name} {statistic}": value for statistic, value in counts.items()}
    return found


def lost_bits(figures: dict, committed: dict) -> list[str]:
    """The comparisons that were equal in every bit and are not any more."""

    def identical(of: dict) -> set[str]:
        pairs = ((name, kind) for name, r in of["runs"].items() for kind in r["against_host_float"])
        return {f"{n}, {k}" for n, k in pairs if of["runs"][n]["against_host_float"][k]["bit_identical"]}

    return sorted(identical(committed) - identical(figures))


def growth(figures: dict, committed: dict) -> tuple[list[str], list[str]]:
    """What has grown beyond the committed figures, and what has shrunk as much."""
    now, before = bounded(figures), bounded(committed)
    if now.keys() != before.keys():
        return [f"{page.COMMITTED} has other figures: {sorted(now.keys() ^ before.keys())}"], []
    grown = [f"{k}: {now[k]:g} for {before[k]:g}" for k in now if now[k] > ALLOWED_GROWTH * before[k]]
    shrunk = [f"{k}: {now[k]:g} for {before[k]:g}" for k in now if now[k] * ALLOWED_GROWTH < before[k]]
    return grown, shrunk


def self_test(host: Path) -> list[str]:
    """What seeded violations slip through."""
    build_firmware()
    slipped = []
    for seed, expected in SEEDS.items():
        built = build(f"seeded_{seed}")
        found = re.search(f"^.*{expected}.*$", built.stdout, re.MULTILINE)
        if not built.returncode or not found:
            slipped.append(f"seeds/{seed}.cpp is not refused for what is wrong with it:\n{built.stdout[-1000:]}")
        else:
            print(f"found: {seed}: {found.group(0).split(': ', 1)[-1].strip()}")
    if build("seeded_double_arithmetic").returncode:
        slipped.append("seeds/double_arithmetic.cpp does not build")
    elif names := firmware_image.forbidden(BUILD / "seeded_double_arithmetic.elf"):
        print(f"found: double_arithmetic: {', '.join(names)}")
    else:
        slipped.append("seeds/double_arithmetic.cpp: its arithmetic is not found in the image")

    one = GoldenRun(host, "immediate")
    for name in (*golden.DECISIONS, *golden.TOLERANCES):
        wrong = one.reference.copy()
        k = one.periods // 3
        if name in golden.TOLERANCES:
            wrong[name][k] += 3 * golden.TOLERANCES[name]
        else:
            wrong[name][k] ^= 1
        if not golden.compare(one.reference, wrong, one.variants).problems:
            slipped.append(f"a wrong {name} in one period is not found")
    print(f"found: a wrong {', '.join((*golden.DECISIONS, *golden.TOLERANCES))} in one period each")

    return slipped


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="check_cortex_m",
        description=__doc__,
        epilog="examples:\n  scripts/check_cortex_m\n  scripts/check_cortex_m --update",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--self-test", action="store_true", help="every seeded violation must be found")
    parser.add_argument("--update", action="store_true", help="make these figures the ones that may not grow")
    parser.add_argument("--host", type=Path, required=True, help="sextant_golden")
    options = parser.parse_args(arguments)
    if not (options.host.is_file() and os.access(options.host, os.X_OK)):
        raise UserError(f"--host: {options.host} is not a program.")
    BUILD.mkdir(parents=True, exist_ok=True)
    if options.self_test:
        problems = self_test(options.host.resolve())
    else:
        figures, problems = measure(options.host.resolve())
        page.write_figures(figures, BUILD / "embedded.json")
        print(page.table(figures))
        if options.update:
            page.save(figures)
            print(f"{page.COMMITTED} and docs/embedded.md are these figures now.")
        else:
            committed = page.load()
            grown, shrunk = growth(figures, committed)
            problems += [f"{text}: was equal in every bit and is not{ADVICE}" for text in lost_bits(figures, committed)]
            problems += [f"more than 2 % above {page.COMMITTED}: {text}{ADVICE}" for text in grown]
            for text in shrunk:
                print(f"more than 2 % below {page.COMMITTED}, scripts/check_cortex_m --update keeps it: {text}")
            problems += page.differences()
    for problem in problems:
        print(f"check_cortex_m: {problem}")
    return 1 if problems else 0


if __name__ == "__main__":
    run("check_cortex_m", main)
