"""How fast the runs of the paper's scenarios are, and what memory the longest takes. True of one machine only."""

import json
import re
import shlex
import subprocess
import time
from pathlib import Path

from .errors import UserError
from .paper_lab import SCENARIOS, Lab
from .paper_numbers import Numbers
from .paths import ROOT

SHORT = (
    "3_1_constant_torque",
    "3_2_reversal",
    "3_3_smooth",
    "3_4_high_torque",
    "hb_1",
    "hb_0_918",
    "hb_0_5",
    "sector_start_0",
)
LONG = ("3_5_nycc_linear", "3_5_nycc_clip", "3_5_nycc_origin", "table6")
FIXED = ("--integrator", "fixed")
SAMPLED = ("--set", "mode=sampled", *FIXED)


def real_time(lab: Lab, scenario: str, arguments: tuple[str, ...], repeats: int) -> tuple[float, float]:
    """Best real-time factor with the trace on, and peak of resident memory. [1], [MB]"""
    summary_file = lab.work / "speed" / "summary.json"
    command = [lab.mil, SCENARIOS / f"{scenario}.toml", *arguments, "--out", summary_file.parent]
    best, memory = 0.0, 0.0
    for _ in range(repeats):
        summary_file.unlink(missing_ok=True)
        program = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while program.poll() is None:
            memory = max(memory, peak_memory(program.pid))
            time.sleep(0.05)
        if program.returncode not in (0, 1) or not summary_file.is_file():
            raise UserError(f"{shlex.join(map(str, command))} failed with status {program.returncode}.")
        summary = json.loads(summary_file.read_text(encoding="utf-8"))
        best = max(best, summary["metrics"]["realtime_factor"])
    return best, memory


def peak_memory(pid: int) -> float:
    """Of a running process, 0 where it has just ended. [MB]

    Resource usage, as the parent gets it, would include the parent's own memory at the fork.
    """
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    except OSError:
        return 0.0
    found = re.search(r"^VmHWM:\s+(\d+) kB$", status, re.MULTILINE)
    return float(found[1]) / 1e3 if found else 0.0


def measure_speed(lab: Lab, numbers: Numbers, quick: bool) -> None:
    """Nothing else of the report may run at the same time."""
    if quick:
        return
    engines = {"cvode": (), "fixed": FIXED, "sampled": SAMPLED}
    for scenario in SHORT:
        for engine, arguments in engines.items():
            record(lab, numbers, scenario, engine, arguments, 3)
    for scenario in LONG:
        for engine in ("fixed", "sampled"):
            memory = record(lab, numbers, scenario, engine, engines[engine], 1)
            command = f"sextant-mil {SCENARIOS}/{scenario}.toml {' '.join(engines[engine])}"
            numbers.add(f"memory/{engine}/{scenario}", memory, "MB", None, "peak of resident memory", command)


def record(lab: Lab, numbers: Numbers, scenario: str, engine: str, arguments: tuple[str, ...], repeats: int) -> float:
    factor, memory = real_time(lab, scenario, arguments, repeats)
    command = f"sextant-mil {SCENARIOS}/{scenario}.toml {' '.join(arguments)}".strip()
    meaning = f"simulated by wall time with the trace on, best of {repeats}"
    numbers.add(f"realtime/{engine}/{scenario}", factor, "1", None, meaning, command)
    return memory
