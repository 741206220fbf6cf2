#pragma once

#include "sextant/control/delay_predictor.hpp"
#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// How a stator voltage u changes the torque. With the unit vector â along the rotor flux and
/// i_q = â × i_s, from the equations of the machine,
///   T = 3/2 p k_r ψ_r i_q
///   dT/dt = 3/2 p k_r ψ_r/σL_s · (â × u − u_hold)
///   u_hold = (R_s + k_r² R_r + σL_s/τ_r) i_q + p ω_m (â · ψ_s)
template <class T = double>
struct TorqueDynamics {
  SpaceVector<T> along;   ///< â [-]
  T psi_r{};              ///< magnitude of the rotor flux [Wb]
  T i_q{};                ///< [A]
  T holding_voltage{};    ///< u_hold, with which the torque stays [V]
  T decay_rate{};         ///< (R_s + k_r² R_r)/σL_s + 1/τ_r, with which i_q decays without voltage [1/s]
  SpaceVector<T> middle;  ///< e^{jφ/2}: what the rotor flux turns by in half of the coming period [-]
};

/// At x, for a period [s].
template <class T>
[[nodiscard]] TorqueDynamics<T> torque_dynamics(const FluxTorqueEstimator<T>& estimator,
                                                const FluxAndCurrent<T>& x, T period) noexcept {
  const InductionMachineParameters<T>& machine = estimator.machine();
  const CurrentModel<T>& model = estimator.current_model();
  const SpaceVector<T> psi_r = model.psi_r_from(x.psi_s, x.i_s);
  const SpaceVector<T> along = direction(psi_r);
  const SpaceVector<T> middle =
      direction(psi_r + (T(0.5) * period) * model.derivative(psi_r, x.i_s, estimator.omega_m()));
  const T i_q = cross(along, x.i_s);
  const T resistance = machine.r_s + machine.k_r() * machine.k_r() * machine.r_r +
                       machine.sigma_l_s() * machine.r_r / machine.l_r();
  const T omega_r = T(machine.pole_pairs) * estimator.omega_m();
  return {.along = along,
          .psi_r = magnitude(psi_r),
          .i_q = i_q,
          .holding_voltage = resistance * i_q + omega_r * dot(along, x.psi_s),
          .decay_rate = resistance / machine.sigma_l_s(),
          .middle = {dot(along, middle), cross(along, middle)}};
}

}  // namespace sextant
