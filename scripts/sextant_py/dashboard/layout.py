"""Which members of DriveTelemetry the page draws together; units and texts come from the contract."""

from dataclasses import dataclass, field

from ..errors import UserError
from ..telemetry_contract import Signal, signals

STRUCT, WAVEFORM = "DriveTelemetry", "DriveWaveform"


@dataclass(frozen=True)
class Panel:
    """One plot: lines by signal and label, and a band between two signals."""

    key: str
    title: str
    lines: dict[str, str]
    band: tuple[str, str] | None = None
    is_wide: bool = False
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", (*self.lines, *(self.band or ())))


_PANELS = (
    Panel(
        "torque",
        "Torque",
        {"torque_requested_nm": "request", "torque_mean_nm": "estimate", "torque_reference_nm": "reference"},
        ("torque_min_nm", "torque_max_nm"),
        is_wide=True,
    ),
    Panel("speed", "Speed", {"speed_rad_s": "measured"}),
    Panel("flux", "Stator flux", {"flux_mean_wb": "estimate"}, ("flux_min_wb", "flux_max_wb")),
    Panel("phases", "Phase currents", {"i_a_a": "a", "i_b_a": "b", "i_c_a": "c"}),
    Panel("current", "Stator current", {"current_mean_a": "magnitude"}, ("current_min_a", "current_max_a")),
    Panel("u_dc", "DC-link voltage", {"u_dc_v": "mean"}),
    Panel("i_dc", "DC-link current", {"i_dc_a": "mean"}),
)
_SCOPE_PANELS = (
    Panel(
        "scope_torque",
        "Torque",
        {"torque_requested_nm": "request", "torque_nm": "estimate", "torque_reference_nm": "reference"},
        is_wide=True,
    ),
    Panel("scope_phases", "Phase currents", {"i_a_a": "a", "i_b_a": "b", "i_c_a": "c"}),
    Panel("scope_flux", "Stator flux", {"flux_alpha_wb": "α", "flux_beta_wb": "β"}),
    Panel("scope_duty", "Duty cycles", {"duty_a": "a", "duty_b": "b", "duty_c": "c"}),
    Panel("scope_speed", "Speed", {"speed_rad_s": "measured"}),
    Panel("scope_u_dc", "DC-link voltage", {"u_dc_v": "measured"}),
    Panel("scope_i_dc", "DC-link current", {"i_dc_a": "mean of a period"}),
)
# Members that the page shows in another way, or not at all.
_NO_PLOT = {"flux_angle_rad", "power_w"}


def panels(struct: str = STRUCT) -> tuple[Panel, ...]:
    """The panels of this contract. Members of the telemetry that no panel names get one a unit: a later contract's
    temperatures."""
    known = {signal.name: signal for signal in signals(struct)}
    standard = _PANELS if struct == STRUCT else _SCOPE_PANELS
    for name in (name for panel in standard for name in panel.names):
        if name not in known:
            raise UserError(f"the telemetry contract has no {struct}.{name}, which the dashboard draws.")
    if struct != STRUCT:
        return standard
    taken = {name for panel in _PANELS for name in panel.names} | _NO_PLOT
    units: dict[str, list[Signal]] = {}
    for signal in known.values():
        if signal.type in ("float", "double") and signal.name not in taken:
            units.setdefault(signal.unit, []).append(signal)
    further = (
        Panel(f"further_{index}", f"Further signals in {unit}", {signal.name: signal.name for signal in found})
        for index, (unit, found) in enumerate(units.items())
    )
    return (*_PANELS, *further)


def described(struct: str = STRUCT) -> list[dict]:
    """The panels of a struct for the page, with unit and text of each signal."""
    known = {signal.name: signal for signal in signals(struct)}
    found = []
    for panel in panels(struct):
        lines = [{"signal": name, "label": label, "text": known[name].text} for name, label in panel.lines.items()]
        unit = known[panel.names[0]].unit
        found.append({"key": panel.key, "title": panel.title, "unit": unit, "lines": lines, "wide": panel.is_wide})
        if panel.band:
            texts = " … ".join(known[name].text for name in panel.band)
            found[-1]["band"] = {"low": panel.band[0], "high": panel.band[1], "text": texts}
    return found
