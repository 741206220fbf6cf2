"""Plant and drive on two machines: two network namespaces with a lossy way between them.

The middle namespace holds a relay that drops, delays and swaps datagrams by a seed, because not every kernel has
netem. Who is not root cannot make namespaces; tests that need them are then skipped, aloud.
How soon the gates turn off after a cut is measured by scripts/bench.
"""

import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from handling import MEASUREMENT_INVALID, at_torque, bring_up
from hil_processes import SILENCE_MS, Side, drive_side, opening_after, openings, plant_side
from network_interface import set_up
from programs import program
from sextant_py.paths import ROOT
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: only root makes network namespaces")

TORQUE_NM = 10.0
PERIOD_US = 500
RELAY = ROOT / "tests" / "python" / "datagram_relay.py"
PLANT_PORT = 47811  # in a namespace of its own
SILENT = "the drive has timed out"
DEAF = "the plant does not acknowledge the drive's patterns"


def free_ports(count: int) -> list[int]:
    """Free UDP ports below those that the kernel hands out, and where no DDS domain has one (7400 + 250·domain on)."""
    candidates = [port for port in range(10_000, 32_768) if (port - 7400) % 250 >= 220]
    found = []
    for port in random.sample(candidates, len(candidates)):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", port))
            except OSError:
                continue
        found.append(port)
        if len(found) == count:
            return found
    raise AssertionError("no free UDP ports")


def dropped_by_kernel(process_id: int, address: str) -> int:
    """Datagrams for which a socket of that process's network had no room; "a.b.c.d:port" is what it is bound to."""
    host, port = address.split(":")
    bound = f"{socket.inet_aton(host)[::-1].hex()}:{int(port):04x}".upper()
    rows = [line.split() for line in Path(f"/proc/{process_id}/net/udp").read_text().splitlines()[1:]]
    drops = [int(row[-1]) for row in rows if row[1] == bound]
    assert len(drops) == 1, f"{address} is bound {len(drops)} times"
    return drops[0]


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
        drive_port, relay_port = free_ports(2)
        self.drive_address = f"127.0.0.1:{drive_port}"
        self.drive_side = f"127.0.0.1:{relay_port}"
        self.plant_side = f"10.83.{self.subnet}.1:{relay_port}"
        self.plant_address = f"10.83.{self.subnet}.2:{PLANT_PORT}"

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
        set_up(self.wire, False)

    def mend(self) -> None:
        set_up(self.wire, True)

    @contextmanager
    def relay(self, *settings: str) -> Iterator[subprocess.Popen]:
        command = [sys.executable, str(RELAY), "--drive-side", self.drive_side, "--drive", self.drive_address]
        command += ["--plant-side", self.plant_side, "--plant", self.plant_address]
        command += settings
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
            f'hil.udp_listen="{self.plant_address}"',
            f'hil.udp_peer="{self.plant_side}"',
        )
        side = plant_side("none", folder, *own, "plant.u_dc_v=60", "plant.hold_periods=3", *settings)
        side.command = ["ip", "netns", "exec", self.plant_space, *side.command]
        return side

    def drive(self, bus: str, domain: int, folder: Path) -> Side:
        own = (
            "power_stage=udp",
            f"drive.period_us={PERIOD_US}",
            f'hil.udp_listen="{self.drive_address}"',
            f'hil.udp_peer="{self.drive_side}"',
            f"hil.missing_periods={SILENCE_MS * 1000 // PERIOD_US}",
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


@needs_root
def test_torque_over_a_network_that_loses_and_swaps(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    lossy = ("--loss", "0.02", "--delayed", "0.02", "--delay-ms", "4", "--seed", "7")
    record = TelemetryRecord(domain)
    with network.relay(*lossy) as relay, network.plant(tmp_path) as plant:
        with network.drive(bus_address, domain, tmp_path) as drive, Vehicle(bus_address) as vehicle:
            vehicle.demand()
            drive.wait_for("the plant answers")

            def no_room() -> dict[str, int]:
                return {
                    "measurements": dropped_by_kernel(drive.process_id, network.drive_address)
                    + dropped_by_kernel(relay.pid, network.plant_side),
                    "commands": dropped_by_kernel(plant.process_id, network.plant_address)
                    + dropped_by_kernel(relay.pid, network.drive_side),
                }

            no_room_before = no_room()  # what has come to a socket that nobody read yet
            relay.send_signal(signal.SIGUSR1)  # lossy from now on, and sound again before a side leaves
            # A network that loses one in fifty does not stop the drive.
            torque_nm = np.median(at_torque(record, vehicle, TORQUE_NM, 1.0).torque_mean_nm)
            print(f"torque {torque_nm:.2f} N·m of {TORQUE_NM} N·m")
            relay.send_signal(signal.SIGUSR1)
            time.sleep(0.2)
            no_room_meanwhile = {way: count - no_room_before[way] for way, count in no_room().items()}
            assert drive.leave() == 0
        assert plant.leave() == 0
        relay.terminate()
        relay_counts = json.loads(relay.stdout.read())
    print(relay_counts, "no room:", no_room_meanwhile)
    for side, way in ((drive, "measurements"), (plant, "commands")):
        check_counts(side, relay_counts[way], no_room_meanwhile[way])


def check_counts(side: Side, relayed: dict[str, int], no_room: int) -> None:
    """What a side has seen of a network is what the network has done."""
    seen = datagrams(side.text())
    print(side.name, seen)
    assert min(relayed["dropped"], relayed["delayed"]) >= 20
    assert seen["lost"] == pytest.approx(relayed["dropped"] + no_room, abs=3)
    # A delayed one that nothing overtook came in order: its sender or the relay stood still meanwhile.
    assert seen["reordered"] == pytest.approx(relayed["overtaken"], abs=3)
    assert seen["late"] >= seen["reordered"] * 0.5


@needs_root
def test_a_cut_wire_turns_the_gates_off_and_trips_the_drive_and_both_come_back(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    with (
        network.relay(),
        network.plant(tmp_path) as plant,
        network.drive(bus_address, domain, tmp_path) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        record = TelemetryRecord(domain)
        vehicle.demand()
        drive.wait_for("the plant answers")
        at_torque(record, vehicle, TORQUE_NM, 0.1)
        silences, answers = (drive.text().count(f"the plant {does}") for does in ("has timed out", "answers"))
        before = len(openings(plant.text(), SILENT))
        network.cut()
        opening_after(plant, SILENT, before)
        record.wait_for_state("FAULT")
        drive.wait_for("the plant has timed out", count=silences + 1)
        network.mend()
        drive.wait_for("the plant answers", count=answers + 1)
        bring_up(record, vehicle, TORQUE_NM)
        assert drive.leave() == 0
        assert plant.leave() == 0


@needs_root
def test_a_way_cut_in_one_direction_trips_the_drive_and_torque_does_not_come_back_by_itself(
    network: Network, bus_address: str, domain: int, tmp_path: Path
) -> None:
    """The drive goes on getting measurements; only its patterns get lost."""
    with (
        network.relay() as relay,
        network.plant(tmp_path) as plant,
        network.drive(bus_address, domain, tmp_path) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        record = TelemetryRecord(domain)
        vehicle.demand()
        drive.wait_for("the plant answers")
        at_torque(record, vehicle, TORQUE_NM, 0.1)
        silences, deaf = len(openings(plant.text(), SILENT)), drive.text().count(DEAF)
        relay.send_signal(signal.SIGUSR2)  # cut
        opening_after(plant, SILENT, silences)
        record.wait_for_state("FAULT")
        drive.wait_for(DEAF, count=deaf + 1)
        record.wait(lambda own: own.states[-1].first_fault == MEASUREMENT_INVALID, "its reason")
        relay.send_signal(signal.SIGUSR2)  # mended
        # The vehicle goes on demanding torque, as before: it is not given without a reset.
        assert set(record.run(0.3).states) == {"FAULT"}
        bring_up(record, vehicle, TORQUE_NM)
        assert drive.leave() == 0
        assert plant.leave() == 0


def test_addresses_that_are_none_are_refused_in_one_sentence() -> None:
    command = [program("sextant-plant"), ROOT / "configs" / "plant.toml", "--set", "transport=udp"]
    found = subprocess.run(
        [*command, "--set", "hil.udp_peer=nowhere"], capture_output=True, text=True, timeout=120, check=False
    )
    assert found.returncode == 2
    assert found.stderr.startswith('sextant-plant: hil.udp_peer: "nowhere" is no <IPv4 address>:<port>')
    assert found.stderr.count("\n") == 1
