"""Part of the stage `live`: deadlines of the drive on a real kernel, by its own stamps. Torque reached, torque gone in
a silence, FAULT, the end of the process, and gates that open when the wire to a plant is cut."""

import os
import select
import signal
import statistics
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

from sextant_py import bus as can_bus
from sextant_py.contract import Contract
from sextant_py.dds import Telemetry
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.vcu import Commander

from . import live_runs
from .figure import Figure, NotMeasurableError
from .gates import SILENT, openings_ns, program, until
from .lab import Lab

ROUNDS = 5
BUS = "udp_multicast:239.74.163.2:43179"
DOMAIN = 201
PERIOD_S, TORQUE_LIMIT_NM = 0.010, 150.0
FROM_NM, TO_NM, NEAR_NM = 15.0, 40.0, 1.5
SETTLED_S = 0.3
REACHED_MS, GONE_MS, LOST_MS, LOST_WITHIN_MS, LEFT_MS, CUT_MS = 10.0, 60.0, 200.0, 5.0, 100.0, 20.0
DRIVE = {"load__kind": "imposed_speed", "load__speed_rad_s__value": 10, "dds__domain": DOMAIN}


class Vehicle(threading.Thread):
    """Repeats its demand every 10 ms; no demand is silence."""

    def __init__(self, bus: Any) -> None:
        super().__init__(daemon=True)
        self._commander = Commander(bus, Contract(), PERIOD_S, TORQUE_LIMIT_NM)
        self._ended = threading.Event()
        self.demand: tuple[float, bool, bool] | None = (0.0, False, False)  # torque, enable, fault reset

    def run(self) -> None:
        while not self._ended.is_set():
            self._commander.wait()
            if (demand := self.demand) is not None:
                self._commander.send(*demand)

    def end(self) -> None:
        self._ended.set()
        self.join()


@dataclass
class Watch:
    """Every sample of the drive's telemetry."""

    telemetry: Telemetry = field(default_factory=lambda: Telemetry(DOMAIN, depth=5000))
    samples: list[Any] = field(default_factory=list)

    def poll(self) -> None:
        self.samples += self.telemetry.poll()

    def wait(self, what: str, condition: Callable[[Any], bool]) -> Any:
        """The first new sample that meets it."""
        seen = len(self.samples)

        def look() -> Any | None:
            nonlocal seen
            self.poll()
            new, seen = self.samples[seen:], len(self.samples)
            return next((sample for sample in new if condition(sample)), None)

        return until(what, look)

    def run(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.poll()
            time.sleep(0.002)


@dataclass(frozen=True)
class Round:
    """Of one start of the drive [ms]."""

    reached: float  # from the reception of a command to the end of the first millisecond with its torque
    gone: float  # age of the last command at which no torque is left
    lost: float  # its age at the first millisecond in FAULT
    left: float  # from SIGTERM at torque to the end of the process


def to_torque(watch: Watch, vehicle: Vehicle, torque_nm: float) -> None:
    vehicle.demand = (0.0, False, True)
    watch.wait("no fault", lambda sample: sample.state.name in ("STANDBY", "READY"))
    vehicle.demand = (0.0, False, False)
    watch.wait("READY", lambda sample: sample.state.name == "READY")
    vehicle.demand = (torque_nm, True, False)
    watch.wait("torque", lambda sample: sample.state.name == "TORQUE")
    watch.run(SETTLED_S)


def reached_ms(watch: Watch, vehicle: Vehicle) -> float:
    vehicle.demand = (TO_NM, True, False)
    asked = watch.wait("the command", lambda sample: abs(sample.torque_requested_nm - TO_NM) < 0.006)
    near = [sample for sample in watch.samples if sample.t_ns >= asked.t_ns]
    there = next((sample for sample in near if abs(sample.torque_mean_nm - TO_NM) <= NEAR_NM), None)
    if there is None:
        there = watch.wait("the torque", lambda sample: abs(sample.torque_mean_nm - TO_NM) <= NEAR_NM)
    return (there.t_ns - asked.command_received_ns) * 1e-6


def silence_ms(watch: Watch, vehicle: Vehicle) -> tuple[float, float]:
    first = len(watch.samples)
    vehicle.demand = None
    fault = watch.wait("FAULT", lambda sample: sample.state.name == "FAULT")
    last_ns = fault.command_received_ns
    gone = next(sample for sample in watch.samples[first:] if sample.torque_reference_nm == 0)
    return (gone.t_ns - last_ns) * 1e-6, (fault.t_ns - last_ns) * 1e-6


def left_ms(drive: subprocess.Popen) -> float:
    gone = os.pidfd_open(drive.pid)
    try:
        began = time.monotonic()
        drive.send_signal(signal.SIGTERM)
        if not select.select([gone], [], [], 10.0)[0]:
            raise UserError("sextant-ecu does not end on SIGTERM")
        return (time.monotonic() - began) * 1e3
    finally:
        os.close(gone)


def measure(lab: Lab) -> Round:
    timing = lab.out / "deadlines.json"
    command = live_runs.ecu_command(timing, 120, BUS, **DRIVE)
    bus = can_bus.open_bus(can_bus.parse(BUS))
    vehicle = Vehicle(bus)
    try:
        with program(command, lab.out / "deadlines_drive.txt") as drive:
            watch = Watch()
            watch.wait("telemetry", lambda _: True)
            vehicle.start()
            to_torque(watch, vehicle, FROM_NM)
            reached = reached_ms(watch, vehicle)
            watch.run(SETTLED_S)
            gone, lost = silence_ms(watch, vehicle)
            to_torque(watch, vehicle, FROM_NM)
            return Round(reached, gone, lost, left_ms(drive))
    finally:
        vehicle.end()
        bus.shutdown()


def figures(rounds: list[Round]) -> list[Figure]:
    def figure(measure: str, values: list[float], **limits: float) -> Figure:
        note = f"{min(values):.3g} to {max(values):.3g} in {len(values)} rounds"
        return Figure(measure, statistics.median(values), unit="ms", note=note, **limits)

    return [
        figure(
            f"live drive: from the reception of a command to the first millisecond with its torque, {FROM_NM:g} to"
            f" {TO_NM:g} N·m",
            [one.reached for one in rounds],
            at_most=REACHED_MS,
        ),
        figure(
            "live drive: age of the last command at which its torque is gone",
            [one.gone for one in rounds],
            at_most=GONE_MS,
        ),
        figure(
            "live drive: age of the last command at the first millisecond in FAULT",
            [one.lost for one in rounds],
            at_least=LOST_MS,
            at_most=LOST_MS + LOST_WITHIN_MS,
        ),
        figure(
            "live drive: from SIGTERM at torque to the end of the process",
            [one.left for one in rounds],
            at_most=LEFT_MS,
        ),
    ]


def deadlines(lab: Lab) -> list[Figure]:
    live_runs.require_real_time()
    os.environ["CYCLONEDDS_URI"] = live_runs.environment()["CYCLONEDDS_URI"]
    rounds = []
    for number in range(ROUNDS):
        rounds.append(measure(lab))
        lab.say(f"deadlines, round {number + 1} of {ROUNDS}: {rounds[-1]}")
    return figures(rounds)


def ip(*arguments: str) -> None:
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise NotMeasurableError(f"ip {' '.join(arguments)}: {done.stderr.strip()}")


@contextmanager
def wire(name: str) -> Iterator[tuple[str, str, str]]:
    """A veth pair into a namespace of the plant's own; its name, and the addresses of drive and plant."""
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
        yield "sxbench", f"{subnet}.1:47810", f"{subnet}.2:47811"


def cut_ms(lab: Lab) -> float:
    """From the cut to the time at which the plant has opened the gates and declared the drive dead."""
    space = f"sextant_bench_{os.getpid()}"
    plant_out = lab.out / "cut_plant.txt"
    common = {"plant__u_dc_v": 60, "plant__hold_periods": 3}
    bus = can_bus.open_bus(can_bus.parse(BUS))
    vehicle = Vehicle(bus)
    try:
        with wire(space) as (link, own, far):
            plant = ["ip", "netns", "exec", space, str(live_runs.PROGRAMS / "sextant-plant")]
            plant += [str(ROOT / "configs" / "plant.toml")]
            plant += live_runs.settings(
                **common, transport="udp", period_us=500, hil__udp_listen=f'"{far}"', hil__udp_peer=f'"{own}"'
            )
            drive = [str(live_runs.PROGRAMS / "sextant-ecu"), str(ROOT / "configs" / "ecu_hil.toml"), "--can", BUS]
            drive += live_runs.settings(
                plant__u_dc_v=60,
                power_stage="udp",
                control__period_us=500,
                hil__udp_listen=f'"{own}"',
                hil__udp_peer=f'"{far}"',
                hil__stale_ms=30,
                hil__missing_periods=60,
                dds__domain=DOMAIN,
            )
            with program(plant, plant_out), program(drive, lab.out / "cut_drive.txt"):
                watch = Watch()
                watch.wait("telemetry", lambda _: True)
                vehicle.start()
                to_torque(watch, vehicle, 10.0)
                before = len(openings_ns(plant_out.read_text(encoding="utf-8"), SILENT))
                cut_ns = time.monotonic_ns()
                ip("link", "set", link, "down")

                def look() -> tuple[int, int] | None:
                    new = openings_ns(plant_out.read_text(encoding="utf-8"), SILENT)[before:]
                    return next((one for one in new if one[1] > cut_ns), None)

                return (until("an opening of the gates", look, 5.0)[1] - cut_ns) * 1e-6
    finally:
        vehicle.end()
        bus.shutdown()


def cut(lab: Lab) -> list[Figure]:
    live_runs.require_real_time()
    if os.geteuid() != 0:
        raise NotMeasurableError("only root makes network namespaces")
    values = []
    for number in range(ROUNDS):
        values.append(cut_ms(lab))
        lab.say(f"cut wire, round {number + 1} of {ROUNDS}: {values[-1]:.2f} ms")
    return [
        Figure(
            "HIL over UDP: from a cut of the wire until the plant has opened the gates and declared the drive dead",
            statistics.median(values),
            unit="ms",
            at_most=CUT_MS,
            note=f"{min(values):.3g} to {max(values):.3g} in {len(values)} rounds",
        )
    ]
