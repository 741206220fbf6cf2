"""Records a live drive with every control period and its CAN frames, and checks that the files have all of it.

A sample that is missing has to be counted, as lost on the way or as dropped or missed by the drive. The packages mcap
and asammdf have to read the MCAP and the MDF4 file alike. Size and processor time are reported.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from . import bus as can_bus
from . import mil_program
from .errors import UserError, run
from .paths import OUT, ROOT
from .program_arguments import parser_of
from .recording import formats
from .recording.losses import LossCounter
from .recording.model import MAIN, Source
from .recording.topics import WAVEFORM

PROFILE = ROOT / "configs" / "profiles" / "demo.csv"
# No machine that stands still trips the drive.
PATIENCE = (
    *("command.timeout_ms=10000", "command.lost_ms=60000", "command.status_timeout_ms=10000"),
    *("command.status_lost_ms=60000", "realtime.watchdog_ms=60000"),
)
START_S, LEAVE_S = 30.0, 900.0
BATCH_PERIODS = 400  # at most
EXAMPLES = """examples:
  check_recording                     ten minutes
  check_recording --minutes 0.2 --domain 9 --bin build/dev/apps
"""


@dataclass(frozen=True)
class Cost:
    wall_s: float
    cpu_s: float
    peak_mib: float

    def described(self) -> dict[str, float]:
        share = 100 * self.cpu_s / self.wall_s
        return {"wall_s": round(self.wall_s, 1), "cpu_s": round(self.cpu_s, 1), "cpu_percent": round(share, 1)} | {
            "peak_mib": round(self.peak_mib, 1)
        }


def measured(command: list[object], log: Path) -> Cost:
    """Runs a program of scripts/ to its end; its words go to the log."""
    begin_s = time.monotonic()
    with log.open("wb") as output:
        process = subprocess.Popen(
            [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=output, stderr=output
        )
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise UserError(f"{command[0]} failed: {log.read_text(encoding='utf-8').strip()[-500:]}")
    return Cost(time.monotonic() - begin_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def long_profile(path: Path, seconds: float) -> None:
    """The demo's profile over and over."""
    from .profile import load

    points = load(PROFILE, "linear").points
    span_s = points[-1].time_s + 0.5
    times = [number * span_s for number in range(int(seconds / span_s) + 1)]
    lines = [f"{begin_s + point.time_s:.3f},{point.torque_nm:g}" for begin_s in times for point in points]
    path.write_text("\n".join(["time_s,torque_nm", *lines]) + "\n", encoding="utf-8")


def record_live(options: argparse.Namespace, folder: Path) -> Cost:
    """The drive under commands, recorded to run.mcap."""
    seconds = 60 * options.minutes
    long_profile(folder / "profile.csv", seconds + 10)
    ecu_command = [options.bin / "sextant-ecu", ROOT / "configs" / "ecu.toml", "--can", options.can]
    settings = (f"dds.domain={options.domain}", *PATIENCE)
    ecu_command += [word for setting in settings for word in ("--set", setting)]
    vcu_command = [ROOT / "scripts" / "vcu", "--profile", folder / "profile.csv", "--can", options.can, "--quiet"]
    with (folder / "ecu.log").open("wb") as ecu_log, (folder / "vcu.log").open("wb") as vcu_log:
        ecu = subprocess.Popen(ecu_command, stdin=subprocess.DEVNULL, stdout=ecu_log, stderr=ecu_log)
        vcu = subprocess.Popen([*vcu_command, "--timeout", str(START_S)], stdout=vcu_log, stderr=vcu_log)
        try:
            time.sleep(1)
            recorder = [ROOT / "scripts" / "record", folder / "run.mcap", "--waveform", "--can", options.can]
            recorder += ["--domain", options.domain, "--duration", seconds]
            return measured(recorder, folder / "record.log")
        finally:
            for process in (vcu, ecu):
                process.terminate()
                process.wait(LEAVE_S)


def numbers_of(source: Source, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Sequence numbers and times [ns] of the rows of a group."""
    blocks = [(block["sequence"].astype(np.int64), block["t_ns"].astype(np.int64)) for block in source.blocks(name)]
    numbers, times = map(np.concatenate, zip(*blocks, strict=True))
    return numbers, times


def numbered(numbers: np.ndarray) -> int:
    """From the first number to the last."""
    return int(numbers[-1] - numbers[0]) + 1


def missed_by_drive(source: Source) -> tuple[int, int, int]:
    """Times of the first and the last statistics [ns], and the control periods missed by the drive between them."""
    rows = np.concatenate(list(source.blocks("statistics")))
    missed = rows["periods_missed"].astype(np.int64)
    return int(rows["t_ns"][0]), int(rows["t_ns"][-1]), int(missed[-1] - missed[0])


def check_losses(source: Source) -> tuple[dict[str, object], list[str]]:
    """Every number of the sequence is a row or counted as lost, and every control period has its reason. The figures,
    and what does not hold."""
    needed = (MAIN, WAVEFORM, "statistics", "can")
    if lacking := [name for name in needed if name not in source.groups or not source.rows(name)]:
        return {}, [f"the recording has no {name}" for name in lacking]
    counter = LossCounter()
    for name in source.groups:
        for block in source.blocks(name):
            counter.take(name, block)
    of, telemetry, (batches, times) = counter.of, numbers_of(source, MAIN)[0], numbers_of(source, WAVEFORM)
    period_ns = int(next(source.blocks(WAVEFORM))["period_ns"][0])
    begin_ns, end_ns, missed = missed_by_drive(source)
    inside = (times[:-1] >= begin_ns) & (times[1:] <= end_ns)
    steps = np.rint(np.diff(times) / period_ns).astype(np.int64)[inside]
    missing = int(np.sum(steps[steps > 1] - 1))
    explained = of[WAVEFORM].dropped + missed + BATCH_PERIODS * of[WAVEFORM].lost
    periods = round((times[-1] - times[0]) / period_ns) + 1
    received = int(np.count_nonzero(np.diff(batches))) + 1
    claims = {
        "the file's losses are not those of its rows": counter.described() == source.metadata["losses"],
        "samples of telemetry are not counted": numbered(telemetry) == len(telemetry) + of[MAIN].lost,
        "batches are not counted": numbered(batches) == received + of[WAVEFORM].lost,
        "control periods are not counted": periods == len(times) + of[WAVEFORM].periods_missing,
        f"{missing} control periods are missing, of which no more than {explained} are explained": missing <= explained,
    }
    return {
        "telemetry_rows": len(telemetry), "telemetry_lost": of[MAIN].lost, "control_periods": len(times),
        "batches_lost": of[WAVEFORM].lost, "periods_dropped_by_drive": of[WAVEFORM].dropped,
        "periods_missing": of[WAVEFORM].periods_missing, "periods_missed_by_drive": missed,
        "can_frames": source.rows("can"),
        "can_frames_missing": sum(losses.lost for name, losses in of.items() if name.startswith("can/")),
    }, [what for what, holds in claims.items() if not holds]  # fmt: skip


def check_mcap(path: Path, source: Source) -> list[str]:
    """By the package mcap: the counts of its summary, and the first messages of a channel."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        topics = {channel.id: channel.topic.removeprefix("/") for channel in summary.channels.values()}
        counts = {topics[number]: count for number, count in summary.statistics.channel_message_counts.items()}
        times = [message.log_time for _, _, message in islice(reader.iter_messages(topics=[f"/{WAVEFORM}"]), 1000)]
    own = next(source.blocks(WAVEFORM))["t_ns"][: len(times)]
    failures = [] if counts == {name: source.rows(name) for name in source.groups} else ["mcap counts other messages"]
    return failures if times and np.array_equal(times, own) else [*failures, "mcap reads other times"]


def check_mdf(path: Path, source: Source) -> list[str]:
    """By asammdf: rows of each group, and the values of two signals."""
    from asammdf import MDF

    with MDF(path) as file:
        numbers = {group.channel_group.acq_name: index for index, group in enumerate(file.groups)}
        rows = {name: file.groups[index].channel_group.cycles_nr for name, index in numbers.items()}
        if rows != {name: source.rows(name) for name in source.groups}:
            return ["asammdf counts other rows"]
        wanted = ((MAIN, "torque_mean_nm"), (WAVEFORM, "torque_nm"))
        same = {name: same_values(file, numbers[group], source, group, name) for group, name in wanted}
    return [f"asammdf reads another {name}" for name, is_same in same.items() if not is_same]


def same_values(file: object, number: int, source: Source, group: str, name: str) -> bool:
    """Whether asammdf reads values, unit and times of a signal as they are in the other file."""
    found, done, first_ns = file.get(name, group=number), 0, None
    for block in source.blocks(group):
        first_ns = int(block["t_ns"][0]) if first_ns is None else first_ns
        seconds = (block["t_ns"] - first_ns) / 1e9
        here = slice(done, done + len(block))
        if not np.array_equal(found.samples[here], block[name]):
            return False
        if not np.allclose(found.timestamps[here] - found.timestamps[0], seconds, rtol=0, atol=1e-8):
            return False
        done += len(block)
    return found.unit == "N·m" and done == len(found.samples)


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("check_recording", __doc__, EXAMPLES)
    parser.add_argument("--minutes", type=float, default=10.0, help="how long to record (default: 10)")
    parser.add_argument("--domain", type=int, default=38, help="DDS domain (default: 38)")
    parser.add_argument("--can", default="udp_multicast:239.74.163.2:43138", metavar="ADDRESS", help="CAN bus")
    parser.add_argument("--bin", type=Path, metavar="DIR", help="programs (default: of the release)")
    folder = OUT / "check_recording"
    parser.add_argument(
        "--out", type=Path, default=folder, metavar="DIR", help=f"where the files go (default: {folder})"
    )
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if not options.minutes > 0:
        raise UserError("--minutes must be above 0.")
    options.bin = options.bin or mil_program.find(None, "sextant-ecu").parent
    if not (options.bin / "sextant-ecu").is_file():
        raise UserError(f"there is no sextant-ecu in {options.bin}; --bin names its directory.")
    can_bus.open_bus(can_bus.parse(options.can)).shutdown()
    folder = options.out
    folder.mkdir(parents=True, exist_ok=True)
    mcap, mdf = folder / "run.mcap", folder / "run.mf4"
    print(f"check_recording: recording {options.minutes:g} minutes to {mcap}", flush=True)
    cost = record_live(options, folder)
    print(f"check_recording: converting to {mdf}", flush=True)
    conversion = measured([ROOT / "scripts" / "convert", mcap, mdf], folder / "convert.log")
    source = formats.open_source(mcap)
    figures, failures = check_losses(source)
    if figures:
        failures += [*check_mcap(mcap, source), *check_mdf(mdf, source)]
    figures |= {f"{path.suffix[1:]}_mib": round(path.stat().st_size / 2**20, 1) for path in (mcap, mdf)}
    report = {"minutes": options.minutes, **figures, "record": cost.described(), "convert": conversion.described()}
    report |= {"check_peak_mib": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1)}
    report |= {"failures": failures}
    text = json.dumps(report, indent=2, ensure_ascii=False)
    (folder / "report.json").write_text(text + "\n", encoding="utf-8")
    print(text)
    for failure in failures:
        print(f"check_recording: {failure}", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    run("check_recording", main)
