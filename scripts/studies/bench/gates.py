"""Part of the stage `live`: deadlines of the drive on a real kernel. Torque reached, torque gone without commands,
FAULT, the end of the process; and how soon the gates of a plant in another process are off when its drive ends or
hangs, or when the wire to it is cut."""

import os
import re
import select
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, TypeVar

from sextant_py import bus as can_bus
from sextant_py.commander import Commander
from sextant_py.contract import Contract
from sextant_py.dds import Telemetry
from sextant_py.errors import UserError

from . import live_runs
from .figure import NotMeasurableError, spread
from .lab import Lab
from .live_runs import CONFIGS, PROGRAMS, program, settings

Found = TypeVar("Found")
Values = dict[str, tuple[float, str]]  # by figure: its value and a note
ROUNDS = 5
BUS = "udp_multicast:239.74.163.2:43178"
DOMAIN = 201
PERIOD_S, TORQUE_LIMIT_NM = 0.010, 150.0
FROM_NM, TO_NM, NEAR_NM = 15.0, 40.0, 1.5
SETTLED_S, BEGIN_WITHIN_S = 0.3, 20.0
WATCHDOG_MS = 10
HOG_PRIORITY, HOG_S = 95, 0.3  # above the control thread, and shorter than the kernel's throttling
TIMED_OUT, LINE_OFF = "the drive has timed out", "the gate-enable line is off"
# A period that a shared machine holds, and a link voltage at which a period's torque stays small.
HIL_DRIVE = {
    "plant__u_dc_v": 200,
    "drive__period_us": 250,
    "hil__measurement_timeout_ms": 20,
    "hil__missing_periods": 80,
}
HIL_PLANT = {"plant__u_dc_v": 200, "period_us": 250, "load__kind": "imposed_speed", "load__speed_rad_s__value": 5}
# Only the drive's own watchdog turns off the gates of a plant whose timeout is so long.
PATIENT = {"hil__pattern_timeout_ms": 60000, "plant__hold_periods": 1000000}
CUT_DRIVE = {"plant__u_dc_v": 60, "power_stage": "udp", "drive__period_us": 500, "hil__measurement_timeout_ms": 30}
CUT_DRIVE |= {"hil__missing_periods": 60}
CUT_PLANT = {"plant__u_dc_v": 60, "plant__hold_periods": 3, "transport": "udp", "period_us": 500}

# Takes its CPU away from everything below its priority, and says since when.
HOG = f"""
import os, sys, time
os.sched_setaffinity(0, {{int(sys.argv[1])}})
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param({HOG_PRIORITY}))
since = time.monotonic_ns()
while time.monotonic_ns() - since < {HOG_S} * 1e9:
    pass
print(since)
"""


def until(what: str, look: Callable[[], Found | None], within_s: float = BEGIN_WITHIN_S) -> Found:
    end = time.monotonic() + within_s
    while (found := look()) is None:
        if time.monotonic() > end:
            raise UserError(f"{what} did not come within {within_s:g} s")
        time.sleep(0.002)
    return found


class Session(threading.Thread):
    """A drive's surroundings: repeats a demand every 10 ms, and keeps every sample of its telemetry."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self._bus = can_bus.open_bus(can_bus.parse(BUS))
        self._commander = Commander(self._bus, Contract(), PERIOD_S, TORQUE_LIMIT_NM)
        self._ended = threading.Event()
        self._telemetry = Telemetry(DOMAIN, depth=5000)
        # Torque, enable, fault reset; None: no commands.
        self.demand: tuple[float, bool, bool] | None = (0.0, False, False)
        self.samples: list[Any] = []

    def run(self) -> None:
        while not self._ended.is_set():
            self._commander.wait()
            if (demand := self.demand) is not None:
                self._commander.send(*demand)

    def __enter__(self) -> "Session":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self.join()
        self._bus.shutdown()

    def wait(self, what: str, condition: Callable[[Any], bool]) -> Any:
        """The first new sample that meets it."""

        def look() -> Any | None:
            new = self._telemetry.poll()
            self.samples += new
            return next((sample for sample in new if condition(sample)), None)

        return until(what, look)

    def to_torque(self, torque_nm: float) -> None:
        self.demand = (0.0, False, True)
        self.wait("no fault", lambda sample: sample.state.name in ("STANDBY", "READY"))
        self.demand = (0.0, False, False)
        self.wait("READY", lambda sample: sample.state.name == "READY")
        self.demand = (torque_nm, True, False)
        settled_ns = self.wait("torque", lambda sample: sample.state.name == "TORQUE").t_ns + SETTLED_S * 1e9
        self.wait("settled torque", lambda sample: sample.t_ns >= settled_ns)


def reached_ms(session: Session) -> float:
    """From the reception of a command to the end of the first millisecond with its torque."""
    session.demand = (TO_NM, True, False)
    asked = session.wait("the command", lambda sample: abs(sample.torque_requested_nm - TO_NM) < 0.006)

    def there(sample: Any) -> bool:
        return abs(sample.torque_mean_nm - TO_NM) <= NEAR_NM

    after = (sample for sample in session.samples if sample.t_ns >= asked.t_ns and there(sample))
    found = next(after, None) or session.wait("the torque", there)
    return (found.t_ns - asked.command_received_ns) * 1e-6


def without_commands_ms(session: Session) -> tuple[float, float]:
    """Age of the last command at which no torque is left, and at the first millisecond in FAULT."""
    first = len(session.samples)
    session.demand = None
    fault = session.wait("FAULT", lambda sample: sample.state.name == "FAULT")
    gone = next(sample for sample in session.samples[first:] if sample.torque_reference_nm == 0)
    return (gone.t_ns - fault.command_received_ns) * 1e-6, (fault.t_ns - fault.command_received_ns) * 1e-6


def left_ms(drive: subprocess.Popen) -> float:
    """From SIGTERM at torque to the end of the process."""
    gone = os.pidfd_open(drive.pid)
    try:
        began = time.monotonic()
        drive.send_signal(signal.SIGTERM)
        if not select.select([gone], [], [], 10.0)[0]:
            raise UserError("sextant-ecu does not end on SIGTERM")
        return (time.monotonic() - began) * 1e3
    finally:
        os.close(gone)


def deadline_round(lab: Lab) -> dict[str, float]:
    load = {"load__kind": "imposed_speed", "load__speed_rad_s__value": 10, "dds__domain": DOMAIN}
    command = live_runs.ecu_command(lab.out / "deadlines.json", 120, BUS, **load)
    with Session() as session, program(command, lab.out / "deadlines_drive.txt") as drive:
        session.to_torque(FROM_NM)
        reached = reached_ms(session)
        settled_ns = session.samples[-1].t_ns + SETTLED_S * 1e9
        session.wait("settled torque", lambda sample: sample.t_ns >= settled_ns)
        gone, lost = without_commands_ms(session)
        session.to_torque(FROM_NM)
        return {"reached": reached, "gone": gone, "lost": lost, "left": left_ms(drive)}


def gates_off_ns(plant_text: str, cause: str) -> list[tuple[int, int]]:
    """Of each time that the gates went off for that cause: since when, and when the plant reported it [ns]."""
    found = re.findall(rf"gates stay off since ([\d.]+) s: {cause};.* seen at ([\d.]+) s", plant_text)
    return [(round(float(since) * 1e9), round(float(seen) * 1e9)) for since, seen in found]


def gates_off_ms(
    lab: Lab,
    plant: live_runs.Command,
    drive: dict[str, object],
    stop: Callable[[Any], int],
    cause: str = TIMED_OUT,
    which: int = 1,
) -> float:
    """From the time that `stop` returns, at torque, to gates off; which: 0 counts until they were off, 1 until the
    plant reported it."""
    out = lab.out / "gates_plant.txt"
    command = [PROGRAMS / "sextant-ecu", CONFIGS / "ecu_hil.toml", "--can", BUS]
    command += settings(**drive, dds__domain=DOMAIN)
    with Session() as session, program(plant, out), program(command, lab.out / "gates_drive.txt") as running:
        session.to_torque(10.0)
        before = len(gates_off_ns(out.read_text(encoding="utf-8"), cause))
        stopped_ns = stop(running)

        def look() -> int | None:
            # Gates off before the stop had another reason.
            new = gates_off_ns(out.read_text(encoding="utf-8"), cause)[before:]
            return next((one[which] for one in new if one[which] > stopped_ns), None)

        return (until("gates off", look, 5.0) - stopped_ns) * 1e-6


def over_shared_memory_ms(lab: Lab, stop: Callable[[Any], int], *way: object, **patience: object) -> float:
    link = {"hil__link": f"sextant_bench_{os.getpid()}_{time.monotonic_ns()}"}
    plant = [PROGRAMS / "sextant-plant", CONFIGS / "plant.toml"]
    plant += settings(**link, **HIL_PLANT, **patience, realtime__cpu=live_runs.other_cpus().split(",")[0])
    own = {"realtime__cpu": live_runs.measured_cpu(), "realtime__watchdog_ms": WATCHDOG_MS}
    return gates_off_ms(lab, plant, link | HIL_DRIVE | own, stop, *way)


def kill(drive: subprocess.Popen) -> int:
    sent_ns = time.monotonic_ns()
    drive.kill()
    return sent_ns


def hang(_: subprocess.Popen) -> int:
    """The control thread's CPU is taken away for a while; the watchdog's thread has the others."""
    hog = subprocess.run([sys.executable, "-c", HOG, str(live_runs.measured_cpu())], capture_output=True, text=True)
    if hog.returncode != 0:
        raise UserError(f"the control thread's CPU cannot be taken away: {hog.stderr.strip()[-200:]}")
    return int(hog.stdout)


def ip(*arguments: str) -> None:
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise NotMeasurableError(f"ip {' '.join(arguments)}: {done.stderr.strip()}")


@contextmanager
def wire(name: str) -> Iterator[tuple[str, str]]:
    """A veth pair `sxbench` into a namespace of the plant's own; the addresses of drive and plant."""
    subnet = f"10.84.{1 + os.getpid() % 250}"
    with ExitStack() as stack:
        ip("netns", "add", name)
        stack.callback(subprocess.run, ["ip", "netns", "delete", name], capture_output=True)
        ip("link", "add", "sxbench", "type", "veth", "peer", "name", "sxbenchp")
        stack.callback(subprocess.run, ["ip", "link", "delete", "sxbench"], capture_output=True)
        ip("link", "set", "sxbenchp", "netns", name)
        ip("address", "add", f"{subnet}.1/24", "dev", "sxbench")
        ip("link", "set", "sxbench", "up")
        ip("-n", name, "address", "add", f"{subnet}.2/24", "dev", "sxbenchp")
        ip("-n", name, "link", "set", "sxbenchp", "up")
        yield f"{subnet}.1:47810", f"{subnet}.2:47811"


def cut_wire(_: subprocess.Popen) -> int:
    cut_ns = time.monotonic_ns()
    ip("link", "set", "sxbench", "down")
    return cut_ns


def cut_ms(lab: Lab) -> float:
    space = f"sextant_bench_{os.getpid()}"
    with wire(space) as (own, far):
        plant = ["ip", "netns", "exec", space, PROGRAMS / "sextant-plant", CONFIGS / "plant.toml"]
        plant += settings(**CUT_PLANT, hil__udp_listen=f'"{far}"', hil__udp_peer=f'"{own}"')
        drive = CUT_DRIVE | {"hil__udp_listen": f'"{own}"', "hil__udp_peer": f'"{far}"'}
        return gates_off_ms(lab, plant, drive, cut_wire)


def medians(lab: Lab, measure: Callable[[], dict[str, float]]) -> Values:
    """Of each figure over the rounds."""
    live_runs.require_real_time()
    os.environ["CYCLONEDDS_URI"] = live_runs.own_environment()["CYCLONEDDS_URI"]
    rounds = []
    for number in range(ROUNDS):
        rounds.append(measure())
        shown = ", ".join(f"{name} {value:.2f} ms" for name, value in rounds[-1].items())
        lab.say(f"round {number + 1} of {ROUNDS}: {shown}")
    values = {name: [one[name] for one in rounds] for name in rounds[0]}
    return {name: (statistics.median(each), spread(each)) for name, each in values.items()}


def deadlines(lab: Lab) -> Values:
    return medians(lab, lambda: deadline_round(lab))


def killed(lab: Lab) -> Values:
    return medians(lab, lambda: {"killed": over_shared_memory_ms(lab, kill)})


def hung(lab: Lab) -> Values:
    if len(os.sched_getaffinity(0)) < 2:
        raise NotMeasurableError("a watchdog beside a control thread that hangs needs a second processor")
    return medians(lab, lambda: {"hung": over_shared_memory_ms(lab, hang, LINE_OFF, 0, **PATIENT) - WATCHDOG_MS})


def cut(lab: Lab) -> Values:
    if os.geteuid() != 0:
        raise NotMeasurableError("only root makes network namespaces")
    return medians(lab, lambda: {"cut": cut_ms(lab)})
