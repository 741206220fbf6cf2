"""The ordinary way into torque production."""

from telemetry_record import TelemetryRecord
from vehicle import Vehicle


def make_ready(record: TelemetryRecord, vehicle: Vehicle) -> None:
    """Disables until the drive is READY."""
    record.wait_until_heard()
    vehicle.demand()
    record.wait_for_state("READY")


def bring_up(record: TelemetryRecord, vehicle: Vehicle, torque_nm: float) -> None:
    """Disables, then enables with a torque, until the drive produces it."""
    make_ready(record, vehicle)
    vehicle.demand(torque_nm, enable=True)
    record.wait_for_state("TORQUE")


def regain(record: TelemetryRecord, vehicle: Vehicle, torque_nm: float) -> None:
    """Back into torque production after a silence, whether or not it was long enough for a fault."""
    record.run(0.05)
    if record.samples[-1].state.name == "FAULT":
        vehicle.demand(fault_reset=True)
        record.wait_for_state("STANDBY")
    bring_up(record, vehicle, torque_nm)
    record.run(0.3)
