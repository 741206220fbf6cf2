#pragma once

#include "sextant/control/current_reference.hpp"
#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The mean stator voltage with which torque and stator flux meet their references at the end of a period [s]
/// that begins with x. In the frame of the rotor flux at that end, with i_s* = i_d + j i_q by
/// `current_reference`, which keeps the current within its limit,
///   ψ_s* = k_r ψ_r + σL_s i_s*,   u = (ψ_s* − ψ_s)/t_period + R_s (i_s + i_s*)/2   [V]
/// Source: B. H. Kenny, R. D. Lorenz, "Stator- and rotor-flux-based deadbeat direct torque control of
/// induction machines", IEEE Trans. Ind. Appl. 39 (2003) 1093–1101.
template <class T>
[[nodiscard]] SpaceVector<T> deadbeat_voltage(const FluxTorqueEstimator<T>& estimator,
                                              const FluxAndCurrent<T>& x, const CurrentDemand<T>& demand,
                                              T period) noexcept {
  const InductionMachineParameters<T>& machine = estimator.machine();
  const CurrentModel<T>& model = estimator.current_model();
  const SpaceVector<T> now = model.psi_r_from(x.psi_s, x.i_s);
  const SpaceVector<T> psi_r = now + period * model.derivative(now, x.i_s, estimator.omega_m());
  const SpaceVector<T> wanted = current_reference(machine, magnitude(psi_r), demand);
  const SpaceVector<T> i_s = product(wanted, direction(psi_r));
  const SpaceVector<T> psi_s = machine.k_r() * psi_r + machine.sigma_l_s() * i_s;
  return (T(1) / period) * (psi_s - x.psi_s) + (T(0.5) * machine.r_s) * (x.i_s + i_s);
}

}  // namespace sextant
