"""The demo's profile by both control methods in sextant-mil: figures of the plant, one beside the other."""

import argparse
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.table import Table

from . import printed_configuration, profile
from .errors import UserError, run
from .paths import ECU, ROOT
from .program_arguments import parser_of
from .sweep_file import Settings, toml_value
from .sweep_point import clean_reason, read_summary
from .sweep_reader import flat

FILES = {"dtc": ECU, "foc": ECU.with_name("ecu_foc.toml")}
SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
PROFILE = ROOT / "configs" / "profiles" / "demo.csv"
STEP_S = 0.5  # of the profile, from 0 to 20 N·m [s]
WINDOW_S = (0.6, 9.4)  # between the profile's steps, with its ramps [s]
TIME_LIMIT_S = 120  # of one run [s]

Metrics = dict[str, float]


def drive_of(programs: Path, file: Path) -> Settings:
    """What the live drive's file and scenarios have in common: the drive and its plant."""
    live = printed_configuration.tables_of(programs / "sextant-ecu", file, what="the drive")
    scenario = printed_configuration.tables_of(programs / "sextant-mil", SCENARIO)
    return flat({name: table for name, table in live.items() if isinstance(table, dict) and name in scenario})


def scenario_of(drive: Settings, directory: Path) -> str:
    points = profile.load(PROFILE)
    table = directory / "torque.csv"
    rows = (f"{point.time_s},{point.torque_nm}" for point in points.points)
    table.write_text("\n".join(["time_s,value", *rows]) + "\n", encoding="utf-8")
    settings = {
        "name": directory.name,
        "duration_s": points.duration_s,
        **drive,
        "profile.torque_nm.shape": "table",
        "profile.torque_nm.file": str(table.resolve()),
        "metrics.step_s": STEP_S,
        "metrics.window_from_s": WINDOW_S[0],
        "metrics.window_to_s": WINDOW_S[1],
        "trace.interval_us": 1000,
    }
    return "".join(f"{key} = {toml_value(value)}\n" for key, value in settings.items())


def measure(programs: Path, method: str, out: Path) -> Metrics:
    """One run; its trace and summary stay in the method's directory."""
    directory = out / method
    directory.mkdir(parents=True, exist_ok=True)
    scenario = directory / "scenario.toml"
    scenario.write_text(scenario_of(drive_of(programs, FILES[method]), directory), encoding="utf-8")
    command = [programs / "sextant-mil", scenario, "--out", directory]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S)
    summary = read_summary(directory)
    if summary is None or done.returncode:
        raise UserError(f"{scenario}: {clean_reason(done.stderr) or 'the run has failed'}.")
    return summary["metrics"]


# What the table says, by the metrics of a run.
ROWS = {
    "torque error, RMS": lambda m: f"{m['torque_error_rms_nm']:.3f} N·m",
    "torque ripple, peak to peak": lambda m: f"{m['torque_ripple_pp_nm']:.2f} N·m",
    "offset of the mean torque": lambda m: f"{m['torque_bias_nm']:+.3f} N·m",
    "response to +20 N·m, 95 %": lambda m: f"{m['response_time_ms']:.2f} ms",
    "stator flux": lambda m: f"{m['flux_min_wb']:.3f} … {m['flux_max_wb']:.3f} Wb",
    "switching frequency of a device": lambda m: f"{m['switching_frequency_hz'] / 1e3:.1f} kHz",
    "largest phase current, magnetising": lambda m: f"{m['peak_current_a']:.1f} A",
    "copper loss": lambda m: f"{m['energy_copper_j'] / 1e3:.3f} kJ",
}


def table_of(found: dict[str, Metrics]) -> Table:
    title = f"The plant by both methods, {WINDOW_S[0]:g} to {WINDOW_S[1]:g} s of the profile (sextant-mil, CVODE)"
    table = Table(title=title, title_justify="left")
    table.add_column("", no_wrap=True)
    for method in found:
        table.add_column(f"{method} ({FILES[method].name})", justify="right", no_wrap=True)
    for name, text in ROWS.items():
        table.add_row(name, *(text(metrics) for metrics in found.values()))
    return table


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "demo_methods",
        "Runs the demo's profile in sextant-mil with the drives of configs/ecu.toml and ecu_foc.toml, "
        "prints figures of their plants beside each other and keeps the traces.",
        "example:\n  python -m sextant_py.demo_methods build/release/apps out/demo",
    )
    parser.add_argument("programs", type=Path, help="directory of sextant-ecu and sextant-mil")
    parser.add_argument("out", type=Path, help="directory for the traces, in one directory a method")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    with ThreadPoolExecutor(len(FILES)) as pool:
        runs = {method: pool.submit(measure, options.programs, method, options.out) for method in FILES}
        found = {method: one.result() for method, one in runs.items()}
    Console().print(table_of(found))
    return 0


if __name__ == "__main__":
    run("demo_methods", main)
