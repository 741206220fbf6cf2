"""A machine by the parameters of the T, the Γ and the inverse-Γ circuit is one machine: in a run, and for the tools."""

import json
import math
import subprocess
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import program
from sextant_py.identify_machine import estimate_of, t_circuit_of
from studies.torque_map.capability import limits_of

R_S, R_R, L_LS, L_LR, L_M = 0.641, 0.332, 0.003, 0.0012, 0.07
L_S, L_R = L_LS + L_M, L_LR + L_M
SIGMA = 1 - L_M**2 / (L_S * L_R)
# By the definitions of Slemon (1989): the rotor's turns are counted otherwise, by L_s/L_m and by L_m/L_r.
GAMMA = {"l_m_h": L_S, "l_sigma_h": L_S / L_M * (L_LS + L_S / L_M * L_LR), "r_r_ohm": (L_S / L_M) ** 2 * R_R}
INVERSE = {"l_m_h": L_M**2 / L_R, "l_sigma_h": SIGMA * L_S, "r_r_ohm": (L_M / L_R) ** 2 * R_R}
FORMS = {
    "T": {"l_ls_h": L_LS, "l_lr_h": L_LR, "l_m_h": L_M, "r_r_ohm": R_R},
    "gamma": GAMMA,
    "inverse_gamma": INVERSE,
}


def keys_of(circuit: str) -> dict[str, object]:
    return {"circuit": circuit, "r_s_ohm": R_S, "poles": 4, "inertia_kg_m2": 0.05} | FORMS[circuit]


def impedance(omega: float, slip: float) -> complex:
    """By the loops of the T circuit."""
    z_m, z_r = 1j * omega * L_M, R_R / slip + 1j * omega * L_LR
    return R_S + 1j * omega * L_LS + z_m * z_r / (z_m + z_r)


@pytest.mark.parametrize("circuit", FORMS)
def test_tools_read_every_circuit(circuit: str) -> None:
    configuration = {f"machine.{key}": value for key, value in keys_of(circuit).items()}
    found = t_circuit_of(configuration)
    for omega in (3.0, 300.0):
        for slip in (-0.2, 0.01, 1.0):
            z_m, z_r = 1j * omega * found.l_m, found.r_r / slip + 1j * omega * found.l_lr
            ours = found.r_s + 1j * omega * found.l_ls + z_m * z_r / (z_m + z_r)
            assert ours == pytest.approx(impedance(omega, slip), rel=1e-12)
    assert estimate_of(configuration) == found
    other = estimate_of(configuration | {"control.machine_estimate.l_m_h": 1.1 * FORMS[circuit]["l_m_h"]})
    assert other.l_m > 1.05 * found.l_m and other.r_s == R_S
    rest = {"capability.voltage_use": 1, "plant.u_dc_v": 500, "control.flux_reference_wb": 1, "capability.torque_nm": 9}
    limits = limits_of(configuration | rest, "none")
    assert limits.l_s == pytest.approx(L_S, rel=1e-12)
    assert 1 - limits.l_m**2 / (limits.l_s * limits.l_r) == pytest.approx(SIGMA, rel=1e-12)


def scenario(circuit: str) -> str:
    keys = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys_of(circuit).items())
    return (
        f'name = "circuit"\ndescription = "x"\nduration_s = 0.6\n[machine]\n{keys}'
        '[control]\ncontroller = "foc"\nflux_reference_wb = 0.9\nadapts_parameters = false\n'
        '[profile.torque_nm]\nshape = "steps"\npoints = [[0, 0], [0.5, 20]]\n'
        '[plant]\nintegrator = "fixed"\n[trace]\nsignals = ["all"]\n'
    )


def run(circuit: str, directory: Path) -> dict[str, np.ndarray]:
    file, out = directory / f"{circuit}.toml", directory / circuit
    file.write_text(scenario(circuit), encoding="utf-8")
    mil = program("sextant-mil")
    found = subprocess.run([mil, file, "--out", out], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    printed = subprocess.run([mil, file, "--print-config"], capture_output=True, text=True, check=True).stdout
    assert tomllib.loads(printed)["machine"]["circuit"] == circuit
    with h5py.File(out / "trace.h5") as trace:
        return {
            f"{group}/{name}": trace[group][name][:].astype(float)
            for group in ("plant", "control")
            for name in trace[group]
            if not name.startswith(("psi_r", "i_r", "l_m", "r_r"))
        }


def test_runs_are_the_same(tmp_path: Path) -> None:
    """At the terminals and at the shaft; the rotor flux, L_m and R_r have the scale of their circuit."""
    runs = {circuit: run(circuit, tmp_path) for circuit in FORMS}
    reference = runs["T"]
    tau_e = reference["plant/torque_nm"]
    assert abs(tau_e[-1] - 20) < 1 and len(reference) > 10
    for circuit in ("gamma", "inverse_gamma"):
        for name, truth in reference.items():
            scale = np.abs(truth[np.isfinite(truth)]).max(initial=1e-3)
            error = np.abs(runs[circuit][name] - truth)[np.isfinite(truth)].max(initial=0)
            assert error <= 1e-9 * scale, f"{circuit}: {name} {error:.2e} of {scale:.3g}"
    assert math.isfinite(scale)
