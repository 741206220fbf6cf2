"""A vehicle control unit of one's own: the hand-shake, two seconds of torque, and back to zero.

It needs `pip install python-can msgpack cantools autosar-e2e` and the DBC.
"""

import argparse
import time
from pathlib import Path

import can
import cantools
from e2e import p11

DBC = Path(__file__).resolve().parents[2] / "configs" / "interfaces" / "sextant.dbc"
PERIOD_S = 0.01

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--group", default="239.74.163.2", help="multicast group of the bus (default: %(default)s)")
parser.add_argument("--port", type=int, default=43113, help="its UDP port (default: %(default)s)")
parser.add_argument("--torque", type=float, default=5.0, help="[N·m] (default: %(default)s)")
options = parser.parse_args()

database = cantools.database.load_file(DBC)
command = database.get_message_by_name("VCU_TorqueCommand")
status = database.get_message_by_name("MCU_TorqueStatus")
# For a CAN interface: can.Bus(interface="socketcan", channel="can0")
bus = can.Bus(interface="udp_multicast", channel=options.group, port=options.port, ignore_config=True)
counter = 0


def send(torque_nm: float, enable: int) -> None:
    """A command with its end-to-end protection: the counter runs from 0 to 14, the data id is the identifier."""
    global counter
    signals = {"TorqueRequest": torque_nm, "TorqueLimit": 50, "Enable": enable, "FaultReset": 0}
    data = bytearray(command.encode({**signals, "Crc": 0, "Counter": counter, "DataIdNibble": 0}, strict=False))
    p11.e2e_p11_protect(data, command.frame_id, data_id_mode=p11.E2E_P11_DATAID_NIBBLE, increment_counter=False)
    bus.send(can.Message(arbitration_id=command.frame_id, data=data, is_extended_id=False))
    counter = (counter + 1) % 15


def latest_status(until_s: float) -> dict | None:
    """The newest status frame whose CRC is right, of those that come until a time."""
    found = None
    while (left_s := until_s - time.monotonic()) > 0:
        frame = bus.recv(left_s)
        if frame is None or frame.arbitration_id != status.frame_id or len(frame.data) != 8:
            continue
        data = bytearray(frame.data)
        p11.e2e_p11_protect(data, status.frame_id, data_id_mode=p11.E2E_P11_DATAID_NIBBLE, increment_counter=False)
        if data == frame.data:
            found = status.decode(bytes(data))
    return found


def run(torque_nm: float, enable: int, duration_s: float, until_state: str = "") -> dict | None:
    """Sends a command every 10 ms, for a time or until the drive reports a state; the last status."""
    last, due_s, end_s = None, time.monotonic(), time.monotonic() + duration_s
    while due_s < end_s and not (until_state and last and str(last["DriveState"]) == until_state):
        send(torque_nm, enable)
        due_s += PERIOD_S
        last = latest_status(due_s) or last
    return last


try:
    if run(0.0, enable=0, duration_s=30.0, until_state="READY") is None:
        raise SystemExit(f"can_client: no drive answers on {options.group}:{options.port}; is sextant-ecu running?")
    run(options.torque, enable=1, duration_s=10.0, until_state="TORQUE")
    reached = run(options.torque, enable=1, duration_s=2.0)
    print(f"{reached['DriveState']}: {reached['TorqueEstimated']:+.2f} N·m of {options.torque:+.2f} N·m")
    run(0.0, enable=1, duration_s=0.1)
finally:
    run(0.0, enable=0, duration_s=0.05)
    bus.shutdown()
