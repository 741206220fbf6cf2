"""The range of the points of a drive: speeds and torques, times, and errors of the sensors.

Speeds and torques of any drive are those of the shipped one, scaled by the speed at which the link is just enough for
the flux, and by the drive's torque limit; so are the errors of the sensors, by the over-current limit and the link.
"""

import math
from dataclasses import dataclass, field

from sextant_py.sweep_file import Settings

_MAGNITUDES = (0, 2, 5, 10, 20, 35, 50, 75, 100, 130, 160, 200, 260, 320, 400)
SPEEDS = tuple(sorted({sign * speed for speed in _MAGNITUDES for sign in (-1, 1)}))  # mechanical [rad/s]
TORQUES = (-130, -60, -15, -2, 0, 2, 15, 60, 130)  # [N·m]
QUICK_SPEEDS, QUICK_TORQUES = (-100, 0, 50, 200), (-15, 15)
TORQUE_FLOOR = 2.0  # smallest deviation that counts [N·m]
# What the shipped drive has, by which the ranges of the map scale.
BASE_SPEED, TORQUE_LIMIT = 530 / math.sqrt(3) / 1.1 / 2, 150.0  # [rad/s], [N·m]
OVER_CURRENT, LINK = 250.0, 530.0  # [A], [V]

# Converters as they are: offsets and gains of opposite sign in two phases, 12 bits over the range, noise.
SENSORS: dict[str, Settings] = {
    "ideal": {},
    "real": {
        "plant.sensors.current.phase_a.offset_a": 0.5,
        "plant.sensors.current.phase_b.offset_a": -0.5,
        "plant.sensors.current.phase_a.gain_error": 0.02,
        "plant.sensors.current.phase_b.gain_error": -0.02,
        "plant.sensors.current.range_a": 300,
        "plant.sensors.current.bits": 12,
        "plant.sensors.current.noise_a": 0.2,
        "plant.sensors.voltage.range_v": 1000,
        "plant.sensors.voltage.bits": 12,
        "plant.sensors.voltage.noise_v": 0.5,
    },
}


@dataclass(frozen=True)
class Scale:
    """The range of the points of a drive; by default that of the shipped one."""

    speeds: tuple[float, ...] = SPEEDS  # mechanical [rad/s]
    torques: tuple[float, ...] = TORQUES  # [N·m]
    quick_speeds: tuple[float, ...] = QUICK_SPEEDS
    quick_torques: tuple[float, ...] = QUICK_TORQUES
    torque_floor: float = TORQUE_FLOOR  # [N·m]
    sensors: dict[str, Settings] = field(default_factory=lambda: SENSORS)
    from_s: float = 0.15  # end of start and magnetising: an imposed speed is evaluated from here on [s]
    step_s: float = 0.35  # end of zero torque; a free shaft has its speed, and is evaluated from here on [s]
    end_s: float = 1.1  # [s]


SHIPPED = Scale()


def rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _sensors(configuration: Settings) -> dict[str, Settings]:
    current = configuration["protection.over_current_a"] / OVER_CURRENT
    voltage = configuration["plant.u_dc_v"] / LINK
    by = {"_a": current, "_v": voltage}
    return {
        name: {key: rounded(value * by.get(key[-2:], 1)) if key[-2:] in by else value for key, value in one.items()}
        for name, one in SENSORS.items()
    }


def scale_of(configuration: Settings) -> Scale:
    """From the configuration in force."""
    pole_pairs = configuration["machine.poles"] // 2
    flux_speed = configuration["plant.u_dc_v"] / math.sqrt(3) / configuration["control.flux_reference_wb"]
    speed = flux_speed / pole_pairs / BASE_SPEED
    limit = min(configuration["command.torque_limit_nm"], configuration["capability.torque_nm"])
    torque = limit / TORQUE_LIMIT
    # As long as magnetising may take, and a tenth of a second.
    from_s = max(0.15, 0.1 + 1e-3 * configuration["drive.magnetise_timeout_ms"])
    return Scale(
        tuple(rounded(speed * value) for value in SPEEDS),
        tuple(rounded(torque * value) for value in TORQUES),
        tuple(rounded(speed * value) for value in QUICK_SPEEDS),
        tuple(rounded(torque * value) for value in QUICK_TORQUES),
        rounded(torque * TORQUE_FLOOR),
        _sensors(configuration),
        from_s,
        from_s + 0.2,
        from_s + 0.95,
    )
