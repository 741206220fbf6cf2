"""Addresses of CAN buses, and what is said when one cannot be opened."""

import subprocess
import sys

import can
import pytest
from sextant_py import bus
from sextant_py.contract import Contract
from sextant_py.errors import UserError
from sextant_py.paths import ROOT


def test_addresses() -> None:
    assert bus.parse("socketcan:vcan0") == bus.Address("socketcan", "vcan0")
    assert bus.parse("udp_multicast:239.74.163.2:43113") == bus.Address("udp_multicast", "239.74.163.2", 43113)
    assert str(bus.parse("udp_multicast:239.1.2.3")) == f"udp_multicast:239.1.2.3:{bus.DEFAULT_PORT}"
    assert str(bus.parse("socketcan:can1")) == "socketcan:can1"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("vcan0", "expected socketcan:"),
        ("socketcan:", "expected socketcan:"),
        ("socketcan:a-name-too-long-for-linux", "expected socketcan:"),
        ("udp_multicast:", "expected socketcan:"),
        ("udp_multicast:10.0.0.1", "not an IPv4 multicast group"),
        ("udp_multicast:239.1.1:5", "not an IPv4 multicast group"),
        ("udp_multicast:239.1.1.1:0", "not a UDP port"),
        ("udp_multicast:239.1.1.1:70000", "not a UDP port"),
        ("udp_multicast:239.1.1.1:x", "not a UDP port"),
    ],
)
def test_bad_addresses(text: str, complaint: str) -> None:
    with pytest.raises(UserError, match=complaint):
        bus.parse(text)


def test_missing_can_interface_is_named() -> None:
    with pytest.raises(UserError, match=r"this kernel has no CAN|there is no CAN interface nocan7"):
        bus.open_bus(bus.parse("socketcan:nocan7"))


def test_missing_multicast_route_is_named() -> None:
    """In a network namespace of its own a process has no route at all."""
    code = "from sextant_py import bus; bus.open_bus(bus.parse('udp_multicast:239.74.163.2:43113'))"
    namespace = ["unshare", "--user", "--map-root-user", "--net"]
    if subprocess.run([*namespace, "true"], capture_output=True).returncode != 0:
        pytest.skip("NOT TESTED: this kernel grants no network namespace")
    found = subprocess.run(
        [*namespace, sys.executable, "-c", code], cwd=ROOT / "scripts", capture_output=True, text=True, timeout=480
    )
    assert found.returncode != 0
    assert "no route for the multicast group 239.74.163.2" in found.stderr
    assert "ip route add 239.0.0.0/8 dev lo" in found.stderr


def test_frames_cross_between_two_buses(bus_address: str) -> None:
    sender, receiver = (bus.open_bus(bus.parse(bus_address)) for _ in range(2))
    try:
        sent = Contract().encode(
            "VCU_TorqueCommand", {"TorqueRequest": -12.34, "TorqueLimit": 100, "Enable": 1, "FaultReset": 0}, counter=3
        )
        sender.send(sent)
        received = bus.receive(receiver, 2.0)
        assert received is not None
        name, signals = Contract().decode(received)
        assert name == "VCU_TorqueCommand"
        assert signals["TorqueRequest"] == pytest.approx(-12.34)
        assert signals["Counter"] == 3
    finally:
        sender.shutdown()
        receiver.shutdown()


@pytest.mark.parametrize(
    "frame",
    [
        can.Message(arbitration_id=0x120, data=bytes(7), is_extended_id=False),
        can.Message(arbitration_id=0x120, data=bytes(8), is_extended_id=True),
        can.Message(arbitration_id=0x120, data=bytes(8), is_extended_id=False, is_fd=True),
        can.Message(arbitration_id=0x120, dlc=8, is_extended_id=False, is_remote_frame=True),
        can.Message(arbitration_id=0x7FF, data=bytes(8), is_extended_id=False),
    ],
    ids=["short", "extended", "fd", "remote", "unknown"],
)
def test_foreign_frames_are_not_decoded(frame: can.Message) -> None:
    assert Contract().decode(frame) is None
