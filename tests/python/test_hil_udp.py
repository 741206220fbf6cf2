"""Plant and drive on two machines: two network namespaces with a lossy way between them.

The middle namespace holds a relay that drops, delays and swaps datagrams by a seed, because not every kernel has
netem. Who is not root cannot make namespaces; these tests are then skipped.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from drive_process import program
from handling import bring_up, make_ready
from hil_processes import Side, drive_side, openings_ns, plant_side
from sextant_py.paths import ROOT
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: only root makes network namespaces")

TORQUE_NM = 10.0
PERIOD_US = 500
RELAY = ROOT / "tests" / "python" / "datagram_relay.py"


def ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)


class Network:
    """Two machines: the plant's, a namespace of its own, and this one, with the relay, for the drive and its bus.

    10.83.<n>.1 is here, 10.83.<n>.2 the plant; the veth pair between them is the wire.
    """

    def __init__(self) -> None:
        self.subnet = 1 + os.getpid() % 250
        self.plant_space = f"sextant_plant_{os.getpid()}"
        self.wire = f"sxw{os.getpid() % 10**6}"

    def __enter__(self) -> "Network":
        far = f"{self.wire}p"
        ip("netns", "add", self.plant_space)
        ip("link", "add", self.wire, "type", "veth", "peer", "name", far)
        ip("link", "set", far, "netns", self.plant_space)
        ip("address", "add", f"10.83.{self.subnet}.1/24", "dev", self.wire)
        ip("link", "set", self.wire, "up")
        ip("-n", self.plant_space, "address", "add", f"10.83.{self.subnet}.2/24", "dev", far)
        ip("-n", self.plant_space, "link", "set", far, "up")
        return self

    def __exit__(self, *_: object) -> None:
        subprocess.run(["ip", "link", "delete", self.wire], capture_output=True, check=False)
        subprocess.run(["ip", "netns", "delete", self.plant_space], capture_output=True, check=False)

    def cut(self) -> None:
        ip("link", "set", self.wire, "down")

    def mend(self) -> None:
        ip("link", "set", self.wire, "up")

    @contextmanager
    def relay(self, *settings: str) -> Iterator[subprocess.Popen]:
        command = [sys.executable, str(RELAY), "--drive-side", "127.0.0.1:47911", "--drive", "127.0.0.1:47910"]
        command += [
            "--plant-side",
            f"10.83.{self.subnet}.1:47911",
            "--plant",
            f"10.83.{self.subnet}.2:47811",
            *settings,
        ]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            try:
                assert process.stdout.readline() == "ready\n"
                yield process
            finally:
                process.terminate()
                process.wait()

    def plant(self, folder: Path, *settings: str) -> Side:
        own = (
            "transport=udp",
            f"period_us={PERIOD_US}",
            f'hil.udp_listen="10.83.{self.subnet}.2:47811"',
            f'hil.udp_peer="10.83.{self.subnet}.1:47911"',
        )
        side = plant_side("none", folder, *own, "plant.u_dc_v=60", "plant.hold_periods=3", *settings)
        side.command = ["ip", "netns", "exec", self.plant_space, *side.command]
        return side

    def drive(self, bus: str, domain: int, folder: Path) -> Side:
        own = (
            "power_stage=udp",
            f"control.period_us={PERIOD_US}",
            'hil.udp_listen="127.0.0.1:47910"',
            'hil.udp_peer="127.0.0.1:47911"',
            "hil.stale_ms=30",
            "hil.missing_periods=60",
            "plant.u_dc_v=60",
        )
        return drive_side("none", bus, domain, folder, *own)


@pytest.fixture
def network() -> Iterator[Network]:
    with ExitStack() as stack:
        yield stack.enter_context(Network())


def datagrams(report: str) -> dict[str, int]:
    words = r"datagrams (\d+) received, (\d+) lost, (\d+) reordered, (\d+) repeated, (\d+) late"
    found = re.search(words, report)
    assert found, report
    return dict(zip(("received", "lost", "reordered", "repeated", "late"), map(int, found.groups()), strict=True))


def to_torque(record: TelemetryRecord, vehicle: Vehicle) -> None:
    record.wait_until_heard()
    vehicle.demand(fault_reset=True)
    record.wait_for_state("STANDBY", "READY")
    make_ready(record, vehicle)
    bring_up(record, vehicle, TORQUE_NM)


def test_torque_over_a_network_that_loses_and_swaps(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    lossy = ("--loss", "0.02", "--delayed", "0.02", "--delay-ms", "4", "--seed", "7")
    record = TelemetryRecord(domain)
    with network.relay(*lossy) as relay, network.plant(tmp_path) as plant:
        with network.drive(bus_address, domain, tmp_path) as drive, Vehicle(bus_address) as vehicle:
            vehicle.demand()
            drive.wait_for("the plant answers")
            to_torque(record, vehicle)
            span = record.run(1.5).last(1.0)
            print(f"torque {span.torque_mean_nm.mean():.2f} N·m of {TORQUE_NM} N·m")
            assert "FAULT" not in span.states, "a network that loses one in fifty stopped the drive"
            assert drive.leave() == 0
        assert plant.leave() == 0
        relay.terminate()
        relay_counts = json.loads(relay.stdout.read())
    print(relay_counts)
    for side, way in ((drive, "measurements"), (plant, "commands")):
        seen = datagrams(side.text())
        print(side.name, seen)
        # What was under way when a side came or left is counted by the one and not by the other.
        assert seen["lost"] == pytest.approx(relay_counts[way]["dropped"], rel=0.25, abs=20)
        assert seen["lost"] > 0
        assert seen["reordered"] == pytest.approx(relay_counts[way]["delayed"], rel=0.25, abs=20)
        assert seen["late"] >= seen["reordered"] * 0.5


def test_a_cut_wire_opens_the_gates_and_trips_the_drive_and_both_come_back(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    record = TelemetryRecord(domain)
    with (
        network.relay(),
        network.plant(tmp_path) as plant,
        network.drive(bus_address, domain, tmp_path) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        vehicle.demand()
        drive.wait_for("the plant answers")
        to_torque(record, vehicle)
        silences = len(openings_ns(plant.text(), "the drive is silent"))
        network.cut()
        cut_ns = time.monotonic_ns()
        plant.wait_for("the drive is silent", count=silences + 1)
        record.wait_for_state("FAULT")
        opened_ns, _, seen_ns = openings_ns(plant.text(), "the drive is silent")[-1]
        print(
            f"gates open {(opened_ns - cut_ns) * 1e-6:.1f} ms after the cut, seen at {(seen_ns - cut_ns) * 1e-6:.1f} ms"
        )
        assert seen_ns - cut_ns <= 50_000_000
        drive.wait_for("the plant is silent")
        network.mend()
        drive.wait_for("the plant answers", count=2)
        to_torque(record, vehicle)
        assert drive.leave() == 0
        assert plant.leave() == 0


def test_addresses_that_are_none_are_refused_in_one_sentence() -> None:
    command = [program("sextant-plant"), ROOT / "configs" / "plant.toml", "--set", "transport=udp"]
    found = subprocess.run(
        [*command, "--set", "hil.udp_peer=nowhere"], capture_output=True, text=True, timeout=20, check=False
    )
    assert found.returncode == 1
    assert found.stderr.startswith('sextant-plant: hil.udp_peer: "nowhere" is no <IPv4 address>:<port>')
    assert found.stderr.count("\n") == 1


def test_a_way_cut_in_one_direction_trips_the_drive_and_torque_does_not_come_back_by_itself(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    """The drive goes on getting measurements; only its patterns get lost."""
    record = TelemetryRecord(domain)
    with (
        network.relay() as relay,
        network.plant(tmp_path) as plant,
        network.drive(bus_address, domain, tmp_path) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        vehicle.demand()
        drive.wait_for("the plant answers")
        to_torque(record, vehicle)
        silences = len(openings_ns(plant.text(), "the drive is silent"))
        relay.send_signal(signal.SIGUSR1)
        plant.wait_for("the drive is silent", count=silences + 1)
        record.wait_for_state("FAULT", timeout_s=2.0)
        drive.wait_for("the plant does not take the drive's patterns")
        record.run(0.1)
        assert record.states[-1].reason.startswith("MEASUREMENT_INVALID")
        relay.send_signal(signal.SIGUSR2)
        # The vehicle goes on demanding torque, as before: it is not given without a reset.
        assert set(record.run(0.3).states) == {"FAULT"}
        to_torque(record, vehicle)
        assert drive.leave() == 0
        assert plant.leave() == 0
