"""The equivalent circuits of an induction machine that `identify` uses.

At its terminals a machine shows four parameters: R_s, and those of the inverse-Γ circuit
  σL_s = L_ls + k_r L_lr,   R_R = k_r² R_r,   L_M = k_r L_m,   k_r = L_m/(L_m + L_lr)
The files have the five of the T circuit: how the leakage divides between stator and rotor, L_ls/L_lr, cannot be
measured and is that of the drive's estimate. Source: G. R. Slemon, "Modelling of induction machines for electric
drives", IEEE Trans. Ind. Appl. 25 (1989) 1126-1131.
"""

import math
from dataclasses import dataclass, replace

from .errors import UserError
from .sweep_file import Settings


@dataclass(frozen=True)
class TCircuit:
    r_s: float
    r_r: float
    l_ls: float
    l_lr: float
    l_m: float

    @property
    def terminals(self) -> "InverseGamma":
        k_r = self.l_m / (self.l_m + self.l_lr)
        return InverseGamma(self.r_s, self.l_ls + k_r * self.l_lr, k_r**2 * self.r_r, k_r * self.l_m)


@dataclass(frozen=True)
class InverseGamma:
    r_s: float
    leakage: float  # σL_s [H]
    r_rotor: float  # R_R [ohm]
    l_magnetising: float  # L_M [H]

    @property
    def tau_r(self) -> float:
        """[s]"""
        return self.l_magnetising / self.r_rotor

    @property
    def gamma(self) -> "Gamma":
        k = self.l_magnetising / (self.leakage + self.l_magnetising)
        return Gamma(self.r_s, self.leakage / k, self.r_rotor / k**2, self.leakage + self.l_magnetising)

    def t_circuit(self, split: float) -> TCircuit:
        """With that L_ls/L_lr: L_ls = split L_lr and L_m² = L_M (L_m + L_lr) in L_s = σL_s + L_M = L_ls + L_m give
        split² L_lr² − (2 split L_s + (1 − split) L_M) L_lr + L_s σL_s = 0."""
        l_s = self.leakage + self.l_magnetising
        half = split * l_s + 0.5 * (1 - split) * self.l_magnetising
        product = l_s * self.leakage
        l_lr = product / (half + math.sqrt(half**2 - split**2 * product))
        l_m = l_s - split * l_lr
        return TCircuit(self.r_s, self.r_rotor * ((l_m + l_lr) / l_m) ** 2, split * l_lr, l_lr, l_m)

    def with_stator_inductance(self, l_s: float) -> "InverseGamma":
        """The machine whose iron saturates to another L_s = σL_s + L_M. In the Γ circuit, all leakage on the rotor's
        side, main flux and L_s alone saturate: leakage L_σ = σL_s/k and rotor resistance R_R/k² stay, k = L_M/L_s. The
        small-signal circuit about a direct flux has the slope of the curve in place of L_s."""
        return replace(self.gamma, l_magnetising=l_s).terminals


@dataclass(frozen=True)
class Gamma:
    """All leakage on the rotor's side."""

    r_s: float
    leakage: float  # [H]
    r_rotor: float  # [ohm]
    l_magnetising: float  # L_s [H]

    @property
    def terminals(self) -> InverseGamma:
        k = self.l_magnetising / (self.l_magnetising + self.leakage)
        return InverseGamma(self.r_s, k * self.leakage, k**2 * self.r_rotor, k * self.l_magnetising)


def without_slope(total_ohm: float, slope_ohm: float) -> float:
    """R_s of what the terminals show."""
    if not total_ohm > slope_ohm:
        raise UserError(
            f"the terminals show a resistance of {total_ohm:.4g} ohm, no more than the inverter's slope resistance "
            f"(drive.inverter.slope_ohm, {slope_ohm:.4g} ohm): lower that."
        )
    return total_ohm - slope_ohm


def _value(configuration: Settings, name: str) -> float | None:
    estimate = configuration.get(f"control.machine_estimate.{name}")
    return configuration.get(f"machine.{name}") if estimate is None else estimate


def inertia_of(configuration: Settings) -> float:
    """What the controller takes it to be. [kg·m²]"""
    return _value(configuration, "inertia_kg_m2")


def _changed(machine: TCircuit, configuration: Settings, table: str, circuit: str) -> TCircuit:
    """With what a table sets, whose inductances and rotor resistance are those of that circuit; where it is not "T",
    with equal leakage inductances, as the programs have it."""

    def inductance(name: str, otherwise: float) -> float:
        if (value := configuration.get(f"{table}.l_{name}_h")) is not None:
            return value
        if (value := configuration.get(f"{table}.x_{name}_ohm")) is not None:
            own = configuration.get(f"{table}.reactance_frequency_hz")
            return value / (2 * math.pi * (own or configuration["machine.reactance_frequency_hz"]))
        return otherwise

    def resistance(name: str, otherwise: float) -> float:
        value = configuration.get(f"{table}.{name}_ohm")
        return otherwise if value is None else value

    r_s = resistance("r_s", machine.r_s)
    if circuit == "T":
        leakages = inductance("ls", machine.l_ls), inductance("lr", machine.l_lr)
        return TCircuit(r_s, resistance("r_r", machine.r_r), *leakages, inductance("m", machine.l_m))
    names = ("r_r_ohm", "l_sigma_h", "x_sigma_ohm", "l_m_h", "x_m_ohm")
    if all(configuration.get(f"{table}.{name}") is None for name in names):
        return replace(machine, r_s=r_s)
    of = machine.terminals if circuit == "inverse_gamma" else machine.terminals.gamma
    found = replace(
        of,
        r_s=r_s,
        leakage=inductance("sigma", of.leakage),
        r_rotor=resistance("r_r", of.r_rotor),
        l_magnetising=inductance("m", of.l_magnetising),
    )
    return (found if isinstance(found, InverseGamma) else found.terminals).t_circuit(1)


def t_circuit_of(configuration: Settings) -> TCircuit:
    """Of [machine], which is complete."""
    none = TCircuit(1, 1, 1, 1, 1)
    return _changed(none, configuration, "machine", configuration.get("machine.circuit") or "T")


def estimate_of(configuration: Settings) -> TCircuit:
    """What the controller takes the machine to be."""
    circuit = configuration.get("control.machine_estimate.circuit") or configuration.get("machine.circuit") or "T"
    return _changed(t_circuit_of(configuration), configuration, "control.machine_estimate", circuit)
