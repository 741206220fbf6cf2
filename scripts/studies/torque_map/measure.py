"""Measures the maps of a drive over sets of conditions, and the torque that it publishes."""

import sys

from studies.parallel import progress_of

from . import capability as torque_map_capability
from . import drive as torque_map_drive
from . import points as torque_map_points
from .points import Conditions, Point
from .results import Results, map_of
from .run import Lab


def measured(
    lab: Lab, sets: list[Conditions], speeds: list[float], torques: list[float], jobs: int, restart: bool
) -> Results:
    """The maps of the drive of the lab; points that were measured before are not run again."""
    drive = lab.drive
    points = torque_map_points.points(sets, speeds, torques)
    kept = lab.take_up(restart)
    left = len(lab.missing(points))
    print(f"torque_map: {drive.label}: {len(points)} points of {len(sets)} sets, {left} to run", flush=True)
    try:
        lab.run(points, jobs, progress_of(left, drive.name, "torque_map"))
    except KeyboardInterrupt:
        print(f"torque_map: {len(lab.records) - kept} points more are kept in {lab.file}.", file=sys.stderr)
        raise
    failed = [point for point in points if lab.records[point.key]["reason"]]
    for point in failed[:3]:
        print(f"torque_map: {point.key}: {lab.records[point.key]['reason']}", file=sys.stderr)
    return Results(
        drive.name, drive.label, drive.version, drive.commit, speeds, torques,
        [map_of(one, speeds, torques, lab.records, drive.scale.torque_floor) for one in sets],
        left_out=drive.left_out,
    )  # fmt: skip


def capability(lab: Lab, speeds: list[float]) -> dict:
    """What the drive publishes at exact parameters and no torque, and what the circuit allows."""
    limits = torque_map_capability.limits_of(lab.drive.configuration, torque_map_drive.CURRENT_LIMIT)
    found: dict = {
        "speeds": speeds,
        "limits": {k: v if v != float("inf") else None for k, v in vars(limits).items()},
    }
    records = [lab.records[Point(Conditions(), speed, 0).key] for speed in speeds]
    for direction, sign in (("motoring", 1), ("regenerating", -1)):
        found[direction] = [record.get(f"torque_{direction}_nm") for record in records]
        found[f"{direction}_analytic"] = [
            round(torque_map_capability.largest_torque(limits, abs(speed), sign), 3) for speed in speeds
        ]
    return found
