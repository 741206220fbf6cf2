"""A name plate: what stands on it, and whether it can be one."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

from .errors import UserError

SQRT3 = math.sqrt(3)
CONNECTIONS = {"star": "star", "y": "star", "wye": "star", "delta": "delta", "d": "delta", "triangle": "delta"}
MOST_POLES = 200
LEAST_POWER_FACTOR = 0.2
LEAST_EFFICIENCY = 0.25
ROUNDING = 1e-6


@dataclass(frozen=True)
class Entry:
    """A value of the plate: its key in a file, and its option by `-` for `_`."""

    key: str
    unit: str
    low: float
    high: float
    needed: bool
    meaning: str

    @property
    def option(self) -> str:
        return "--" + self.key.replace("_", "-")


# The keys are those of configs/machines/library.toml where it has them.
ENTRIES = (
    Entry("power_w", "W", 1, 1e8, True, "rated power at the shaft"),
    Entry("voltage_v", "V", 10, 2e4, True, "rated voltage between two lines, RMS, in the connection used"),
    Entry("current_a", "A", 1e-2, 1e5, True, "rated current of a line, RMS, in the connection used"),
    Entry("speed_rpm", "r/min", 10, 1e5, True, "rated speed"),
    Entry("frequency_hz", "Hz", 5, 1000, True, "rated frequency"),
    Entry("power_factor", "", LEAST_POWER_FACTOR, 1, True, "rated power factor cos phi"),
    Entry("poles", "", 2, MOST_POLES, False, "number of poles; default: by speed and frequency"),
    Entry("breakdown_ratio", "", 1.05, 20, False, "breakdown torque by rated torque, of the data sheet"),
    Entry("starting_ratio", "", 1.05, 30, False, "starting current by rated current, of the data sheet"),
    Entry(
        "r_s_ohm",
        "ohm",
        1e-6,
        1e4,
        False,
        "measured resistance of a winding, warm: line to line half in star, 3/2 in delta",
    ),
    Entry("other_losses_w", "W", 0, 1e8, False, "known losses of iron, friction and stray at the rated point"),
    Entry("max_speed_rpm", "r/min", 10, 1e5, False, "largest speed that the machine is made for; default: synchronous"),
    Entry("inertia_kg_m2", "kg·m²", 1e-9, 1e5, False, "inertia of rotor and load"),
)
BY_KEY = {entry.key: entry for entry in ENTRIES}


@dataclass(frozen=True)
class NamePlate:
    """Voltage between lines and current of a line, RMS, as the machine is connected."""

    power_w: float
    voltage_v: float
    current_a: float
    speed_rpm: float
    frequency_hz: float
    power_factor: float
    connection: str  # "star" or "delta"
    poles: int
    breakdown_ratio: float | None = None
    starting_ratio: float | None = None
    r_s_ohm: float | None = None  # of a winding [ohm]
    other_losses_w: float | None = None
    max_speed_rpm: float | None = None
    inertia_kg_m2: float | None = None

    @property
    def pole_pairs(self) -> int:
        return self.poles // 2

    @property
    def omega_s(self) -> float:
        """Electrical angular frequency. [rad/s]"""
        return 2 * math.pi * self.frequency_hz

    @property
    def speed_rad_s(self) -> float:
        return self.speed_rpm * math.pi / 30

    @property
    def torque_nm(self) -> float:
        """At the shaft: T = P/ω_m."""
        return self.power_w / self.speed_rad_s

    @property
    def synchronous_rad_s(self) -> float:
        return self.omega_s / self.pole_pairs

    @property
    def slip(self) -> float:
        return 1 - self.speed_rad_s / self.synchronous_rad_s

    @property
    def phase_voltage(self) -> float:
        """Of the equivalent star, RMS. A delta has the same as seen from its lines. [V]"""
        return self.voltage_v / SQRT3

    @property
    def input_w(self) -> float:
        """P_in = √3 U I cos φ."""
        return SQRT3 * self.voltage_v * self.current_a * self.power_factor

    @property
    def efficiency(self) -> float:
        return self.power_w / self.input_w

    @property
    def stator_side_losses_w(self) -> float:
        """What is lost before the rotor and at the shaft: P_in − P/(1 − s), stator winding, iron, friction, stray."""
        return self.input_w - self.power_w / (1 - self.slip)

    @property
    def star_r_s_ohm(self) -> float | None:
        """The measured resistance in the equivalent star: a delta's winding counts a third."""
        if self.r_s_ohm is None:
            return None
        return self.r_s_ohm / (3 if self.connection == "delta" else 1)


def read_file(file: Path) -> dict:
    """The entries of a name plate's file."""
    try:
        found = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{file} cannot be read: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UserError(f"{file} is no TOML: {error}.") from None
    known = {*BY_KEY, "connection"}
    for key in found:
        if key not in known:
            raise UserError(f"{file}: {key} is unknown; the keys of a name plate are {', '.join(sorted(known))}.")
    return found


def checked(given: dict) -> NamePlate:
    """The plate of such values. Raises UserError: what, where and what to do."""
    values = {key: _number(BY_KEY[key], value) for key, value in given.items() if key != "connection"}
    for entry in ENTRIES:
        if entry.needed and entry.key not in values:
            raise UserError(f"{entry.key} is missing ({entry.meaning}): give {entry.option}, or the key in the file.")
    connection = _connection(given.get("connection"))
    synchronous_poles = _poles_of(values["speed_rpm"], values["frequency_hz"])
    poles = _checked_poles(values.pop("poles", synchronous_poles), synchronous_poles, values)
    plate = NamePlate(**values, connection=connection, poles=poles)
    if plate.max_speed_rpm is not None and plate.max_speed_rpm < plate.speed_rpm:
        raise UserError(
            f"max_speed_rpm (--max-speed-rpm) of {plate.max_speed_rpm:g} r/min is below the rated {plate.speed_rpm:g} "
            "r/min: raise it or leave it out."
        )
    _check_powers(plate)
    _check_given_losses(plate)
    return plate


def _number(entry: Entry, value: object) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and entry.low <= value <= entry.high:
        return value
    unit = f" {entry.unit}" if entry.unit else ""
    raise UserError(
        f"{entry.key} ({entry.option}) is {value!r}: expected a number from {entry.low:g} to {entry.high:g}{unit}, "
        f"the {entry.meaning.split(';')[0]}."
    )


def _connection(value: object) -> str:
    if value is None:
        raise UserError(
            "connection is missing: give --connection star or --connection delta, as the machine is wired for the "
            "voltage and current given."
        )
    name = CONNECTIONS.get(str(value).lower())
    if name is None:
        raise UserError(f'connection (--connection) is "{value}", which is unknown: give star (Y) or delta (D).')
    return name


def _poles_of(speed_rpm: float, frequency_hz: float) -> int:
    """Those whose synchronous speed is the least one above the speed."""
    ratio = 60 * frequency_hz / speed_rpm
    pairs = math.ceil(ratio) - 1
    if ratio > 1.5 and abs(ratio - round(ratio)) < ROUNDING:
        raise UserError(
            f"speed_rpm (--speed-rpm) is {speed_rpm:g} r/min, the synchronous speed of {2 * round(ratio)} poles at "
            f"{frequency_hz:g} Hz, which a motor has without torque alone: give the speed at rated power."
        )
    if pairs < 1:
        raise UserError(
            f"speed_rpm (--speed-rpm) of {speed_rpm:g} r/min is not below {60 * frequency_hz:g} r/min, the synchronous "
            f"speed of two poles at {frequency_hz:g} Hz, and a motor runs below it: correct speed or frequency."
        )
    return 2 * pairs


def _checked_poles(poles: float, by_speed: int, values: dict) -> int:
    speed, frequency = values["speed_rpm"], values["frequency_hz"]
    if poles != int(poles) or int(poles) % 2:
        raise UserError(f"poles (--poles) is {poles:g}: expected an even number, two for each pole pair.")
    if by_speed > MOST_POLES:
        raise UserError(
            f"speed_rpm (--speed-rpm) of {speed:g} r/min at {frequency:g} Hz is that of {by_speed} poles, and machines "
            f"have at most {MOST_POLES}: correct speed or frequency."
        )
    synchronous = 120 * frequency / poles
    if speed >= synchronous:
        raise UserError(
            f"speed_rpm (--speed-rpm) of {speed:g} r/min is not below {synchronous:g} r/min, the synchronous speed of "
            f"{int(poles)} poles at {frequency:g} Hz: {by_speed} poles fit, or correct the speed."
        )
    if int(poles) != by_speed:
        raise UserError(
            f"poles (--poles) is {int(poles)}, whose synchronous speed at {frequency:g} Hz is {synchronous:g} r/min: "
            f"{speed:g} r/min would be a slip of {1 - speed / synchronous:.0%}; {by_speed} poles fit, or correct speed "
            "or frequency."
        )
    return by_speed


def _check_powers(plate: NamePlate) -> None:
    """That power goes in at the lines and comes out at the shaft, and what is lost between has room for its parts."""
    line = f"√3 · {plate.voltage_v:g} V · {plate.current_a:g} A"
    if plate.power_factor >= 1:
        raise UserError(
            "power_factor (--power-factor) is 1, and an induction machine takes a magnetising current besides the "
            "power: give the cos phi of the plate, below 1."
        )
    if plate.power_w >= plate.input_w:
        raise UserError(
            f"power_w (--power-w) of {plate.power_w:g} W is not below {plate.input_w:.0f} W, the input {line} · "
            f"{plate.power_factor:g}: power is in watts, voltage and current are those of one connection; correct them."
        )
    if plate.efficiency < LEAST_EFFICIENCY:
        raise UserError(
            f"power_w (--power-w) of {plate.power_w:g} W is {plate.efficiency:.1%} of the input {line} · "
            f"{plate.power_factor:g}, and machines reach {LEAST_EFFICIENCY:.0%} at least: power is in watts, "
            "and 2.2 kW are 2200."
        )
    rotor = plate.power_w * plate.slip / (1 - plate.slip)
    if plate.stator_side_losses_w <= 0:
        raise UserError(
            f"speed_rpm (--speed-rpm) of {plate.speed_rpm:g} r/min is a slip of {plate.slip:.1%}, by which the rotor "
            f"loses {rotor:.0f} W, and power, voltage, current and cos phi leave {plate.input_w - plate.power_w:.0f} W "
            "for all losses: correct the one that is misread."
        )


def _check_given_losses(plate: NamePlate) -> None:
    """That a measured winding or known losses fit what the plate leaves beside the rotor."""
    if plate.other_losses_w is not None and plate.other_losses_w >= plate.stator_side_losses_w:
        raise UserError(
            f"other_losses_w (--other-losses-w) of {plate.other_losses_w:g} W is not below "
            f"{plate.stator_side_losses_w:.0f} W, what the plate leaves beside the rotor: lower it."
        )
    resistance = plate.star_r_s_ohm
    if resistance is not None and 3 * resistance * plate.current_a**2 > (1 + ROUNDING) * plate.stator_side_losses_w:
        raise UserError(
            f"r_s_ohm (--r-s-ohm) of {plate.r_s_ohm:g} ohm takes {3 * resistance * plate.current_a**2:.0f} W in "
            f"{plate.connection}, and the plate leaves {plate.stator_side_losses_w:.0f} W beside the rotor: give the "
            "resistance of one winding, in the connection used."
        )
    if plate.breakdown_ratio is not None and plate.starting_ratio is not None:
        raise UserError(
            "breakdown_ratio and starting_ratio (--breakdown-ratio, --starting-ratio) both decide the leakage: give "
            "one of them."
        )
    if resistance is not None and plate.other_losses_w is not None:
        raise UserError(
            "r_s_ohm and other_losses_w (--r-s-ohm, --other-losses-w) each follow from the other by the plate's power: "
            "give one of them."
        )
