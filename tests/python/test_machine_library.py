"""The published machines: the rated point of each, by its circuit and by its source; and the study over them."""

import cmath
import math
import tomllib

import pytest
from sextant_py.paths import ROOT

MACHINES = ROOT / "configs" / "machines"
LIBRARY = tomllib.loads((MACHINES / "library.toml").read_text(encoding="utf-8"))["machine"]
NAMES = [entry["file"].removesuffix(".toml") for entry in LIBRARY]
SPEED_TOLERANCE, CURRENT_TOLERANCE, COMPUTED_TOLERANCE = 0.015, 0.10, 0.01


def impedances(entry: dict) -> tuple[float, float, float, float, float, int]:
    """Of a machine's file at the rated frequency: R_s, R_r, X_ls, X_lr, X_m [ohm], and pole pairs."""
    machine = tomllib.loads((MACHINES / entry["file"]).read_text(encoding="utf-8"))
    of_file = 2 * math.pi * machine["reactance_frequency_hz"]
    scale = entry["frequency_hz"] / machine["reactance_frequency_hz"]

    def reactance(name: str) -> float:
        return scale * machine.get(f"x_{name}_ohm", of_file * machine.get(f"l_{name}_h", 0.0))

    return (
        machine["r_s_ohm"], machine["r_r_ohm"], reactance("ls"), reactance("lr"), reactance("m"), machine["poles"] // 2
    )  # fmt: skip


def operating_point(entry: dict, slip: float) -> dict[str, float]:
    """Of the T-equivalent circuit at rated voltage and frequency, by the loop equations of its two meshes."""
    r_s, r_r, x_ls, x_lr, x_m, pole_pairs = impedances(entry)
    z_s, z_r, z_m = complex(r_s, x_ls), complex(r_r / slip, x_lr), complex(0, x_m)
    voltage = entry["voltage_v"] / math.sqrt(3)
    # (z_s + z_m) i_s − z_m i_r = u, −z_m i_s + (z_r + z_m) i_r = 0
    determinant = (z_s + z_m) * (z_r + z_m) - z_m**2
    i_s, i_r = voltage * (z_r + z_m) / determinant, voltage * z_m / determinant
    synchronous = 2 * math.pi * entry["frequency_hz"] / pole_pairs
    torque = 3 * abs(i_r) ** 2 * r_r / slip / synchronous
    return {
        "torque_nm": torque,
        "power_w": torque * synchronous * (1 - slip),
        "current_a": abs(i_s),
        "power_factor": math.cos(cmath.phase(i_s)),
        "speed_rpm": synchronous * (1 - slip) * 30 / math.pi,
        "input_w": 3 * voltage * i_s.real,
        "losses_w": 3 * (r_s * abs(i_s) ** 2 + r_r * abs(i_r) ** 2),
    }


def published_slip(entry: dict) -> float:
    pole_pairs = impedances(entry)[-1]
    return 1 - entry["speed_rpm"] * pole_pairs / (60 * entry["frequency_hz"])


def rated_torque(entry: dict) -> float:
    return entry.get("torque_nm", entry["power_w"] / (entry["speed_rpm"] * math.pi / 30))


def slip_of_torque(entry: dict, torque: float) -> float:
    """Below breakdown, where torque rises with slip: by bisection."""
    low, high = 1e-6, 2 * published_slip(entry)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if operating_point(entry, middle)["torque_nm"] < torque else (low, middle)
    return low


@pytest.mark.parametrize("entry", LIBRARY, ids=NAMES)
def test_rated_point_is_the_published_one(entry: dict) -> None:
    if entry["kind"] == "computed":
        found = operating_point(entry, published_slip(entry))
        for key in ("power_w", "torque_nm", "current_a", "power_factor"):
            if key in entry:
                assert found[key] == pytest.approx(entry[key], rel=COMPUTED_TOLERANCE), key
        return
    assert entry["kind"] == "nameplate"
    found = operating_point(entry, slip_of_torque(entry, rated_torque(entry)))
    assert found["torque_nm"] == pytest.approx(rated_torque(entry), rel=1e-9)
    assert found["speed_rpm"] == pytest.approx(entry["speed_rpm"], rel=SPEED_TOLERANCE)
    if "current_a" in entry:
        assert found["current_a"] == pytest.approx(entry["current_a"], rel=CURRENT_TOLERANCE)


@pytest.mark.parametrize("entry", LIBRARY, ids=NAMES)
def test_power_of_the_rated_point_is_conserved(entry: dict) -> None:
    found = operating_point(entry, published_slip(entry))
    assert found["input_w"] == pytest.approx(found["power_w"] + found["losses_w"], rel=1e-12)


def test_library_is_wide_and_complete() -> None:
    files = {file.name for file in MACHINES.glob("*.toml")} - {"library.toml", "paper_3hp.toml"}
    assert {entry["file"] for entry in LIBRARY} == files
    assert len(LIBRARY) >= 10
    assert all(entry["source"] and entry["name"] for entry in LIBRARY)
    powers = [entry["power_w"] for entry in LIBRARY]
    assert min(powers) < 200 and max(powers) > 150e3
    assert {impedances(entry)[-1] for entry in LIBRARY} >= {1, 2, 3, 4}


@pytest.mark.parametrize("entry", LIBRARY, ids=NAMES)
def test_link_is_the_rated_voltage_rectified(entry: dict) -> None:
    assert entry["u_dc_v"] == pytest.approx(math.sqrt(2) * entry["voltage_v"], rel=0.003)
