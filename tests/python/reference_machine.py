"""An integration of the induction machine of its own: nothing of it is shared with the programs.

The equations are those of currents and an inductance matrix, as complex numbers in the stationary frame,
    psi = L i,   dpsi_s/dt = u_s - R_s i_s,   dpsi_r/dt = -R_r i_r + j p omega psi_r,
    J domega/dt = tau_e - tau_l,   tau_e = 3/2 p Im(conj(psi_s) i_s),
which are polynomials of the state, so that the Taylor series of the solution follows by recurrence. At a constant
voltage it is summed up to the order at which it is exact to rounding. Source: E. Hairer, S. P. Norsett, G. Wanner,
Solving Ordinary Differential Equations I, I.8. All machines are integrated at once, an element of the arrays each.
"""

import numpy as np
from machines import Machine

ORDER = 12


class ReferenceMachines:
    """At rest and without flux; the load torque is a fifth of the rated one."""

    def __init__(self, machines: list[Machine]) -> None:
        def of(name: str) -> np.ndarray:
            return np.array([getattr(m, name) for m in machines], dtype=float)

        l_s, l_r, l_m = of("l_ls") + of("l_m"), of("l_lr") + of("l_m"), of("l_m")
        determinant = l_s * l_r - l_m**2
        self._ss, self._sr, self._rr = l_r / determinant, l_m / determinant, l_s / determinant
        self._r_s, self._r_r, self._p, self._j = of("r_s"), of("r_r"), of("pole_pairs"), of("inertia")
        self.tau_l = 0.2 * of("rated_torque")
        self.psi_s = np.zeros(len(machines), dtype=complex)
        self.psi_r = np.zeros(len(machines), dtype=complex)
        self.omega = np.zeros(len(machines))

    def torque(self) -> np.ndarray:
        i_s = self._ss * self.psi_s - self._sr * self.psi_r
        return 1.5 * self._p * (self.psi_s.conj() * i_s).imag

    def advance(self, u_s: np.ndarray, h: float, order: int = ORDER) -> None:
        """By the time h [s] at the stator voltage u_s [V]."""
        n = self.omega.size
        psi_s, psi_r, i_s = (np.zeros((order + 1, n), dtype=complex) for _ in range(3))
        omega = np.zeros((order + 1, n))
        psi_s[0], psi_r[0], omega[0] = self.psi_s, self.psi_r, self.omega
        for k in range(order):
            i_s[k] = self._ss * psi_s[k] - self._sr * psi_r[k]
            i_r = self._rr * psi_r[k] - self._sr * psi_s[k]
            torque = 1.5 * self._p * (psi_s[: k + 1].conj() * i_s[k::-1]).sum(axis=0).imag
            turned = 1j * self._p * (omega[: k + 1] * psi_r[k::-1]).sum(axis=0)
            first = 1.0 if k == 0 else 0.0
            psi_s[k + 1] = (first * u_s - self._r_s * i_s[k]) / (k + 1)
            psi_r[k + 1] = (turned - self._r_r * i_r) / (k + 1)
            omega[k + 1] = (torque - first * self.tau_l) / (self._j * (k + 1))
        powers = h ** np.arange(order + 1)
        self.psi_s, self.psi_r, self.omega = powers @ psi_s, powers @ psi_r, powers @ omega
