"""The overview of a file: torque, stator flux, speed and current over time, and what else a trace holds."""

from .panels import Line, Panel, changes, merged
from .series import Series, SeriesFile

# Heading, unit, and the quantities of a panel: of each the first that the file has.
QUANTITIES = (
    (
        "Torque [N·m]",
        "N·m",
        (("torque_nm", "plant/torque_nm"), ("torque_requested_nm",), ("torque_reference_nm",)),
    ),
    ("Stator flux linkage [Wb]", "Wb", (("flux_wb", "plant/flux_wb"),)),
    ("Rotor speed, mechanical [rad/s]", "rad/s", (("speed_rad_s", "plant/omega_m_rad_s"),)),
    ("Stator current vector [A]", "A", (("current_a", "plant/current_a"),)),
)
# What a trace holds beside its standard signals: heading and signals of a panel.
FURTHER_PANELS = (
    ("Switching states of the legs a, b, c", ("plant/switch_a", "plant/switch_b", "plant/switch_c")),
    ("Comparator outputs", ("control/torque_comparator", "control/flux_comparator")),
    ("Stator voltage [V]", ("plant/u_s_alpha_v", "plant/u_s_beta_v")),
    ("DC-link current at the end of each row [A]", ("plant/i_dc_a",)),
    ("Rotor current [A]", ("plant/i_r_alpha_a", "plant/i_r_beta_a")),
    ("Shaft angle [rad]", ("plant/theta_m_rad",)),
    ("Torque of the shaft to the load [N·m]", ("plant/shaft_torque_nm",)),
    ("Speed of the load [rad/s]", ("plant/load_speed_rad_s",)),
    (
        "Energies [J]",
        (
            "plant/energy_link_j",
            "plant/energy_shaft_j",
            "plant/energy_copper_j",
            "plant/energy_iron_j",
            "plant/energy_field_j",
        ),
    ),
    (
        "Temperatures [°C]",
        ("plant/winding_temperature_c", "plant/rotor_temperature_c", "plant/housing_temperature_c"),
    ),
)


def _quantity(file: SeriesFile, names: tuple[str, ...]) -> list[Line]:
    """The mean with its band of minimum and maximum; a trace sampled each period may have the signal itself."""
    for name in names:
        parts = [series for series in file.series.values() if name in (series.quantity, series.name)]
        if lines := merged(parts, ""):
            return lines[:1]
    return []


def quantities(file: SeriesFile) -> list[Panel]:
    return [
        Panel(heading, unit, [line for names in wanted for line in _quantity(file, names)])
        for heading, unit, wanted in QUANTITIES
    ]


def further(file: SeriesFile) -> list[Panel]:
    """The panels of which there is at least one signal; the channels of a controller by their units."""
    panels, drawn = [], set()
    for heading, names in FURTHER_PANELS:
        drawn.update(names)
        if found := [file.series[name] for name in names if name in file.series]:
            panels.append(Panel(heading, found[0].unit, merged(found, "")))
    channels: dict[str, list[Series]] = {}
    for name, series in file.series.items():
        if name.startswith("control/") and name not in drawn:
            channels.setdefault(series.unit, []).append(series)
    panels += [Panel(f"Controller [{unit or '?'}]", unit, merged(found, "")) for unit, found in channels.items()]
    states = [series for name in ("state", "derating_cause") if (series := file.series.get(name)) and changes(series)]
    return [*panels, *([Panel("States", "1", merged(states, ""))] if states else [])]


def arrange(file: SeriesFile) -> list[Panel]:
    return [*quantities(file), *further(file)]
