#pragma once

#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Stator flux and current at one instant.
template <class T = double>
struct FluxAndCurrent {
  SpaceVector<T> psi_s{};  ///< [Wb]
  SpaceVector<T> i_s{};    ///< [A]
};

/// Predicts ψ_s and i_s from those at an instant, after the mean stator voltage u_s [V] of a pattern over
/// dt [s], by the machine model and one step of the midpoint rule. A controller whose pattern is applied one
/// period late decides on the prediction. Source: P. Cortés et al., "Delay compensation in model predictive
/// current control of a three-phase inverter", IEEE Trans. Ind. Electron. 59 (2012) 1323–1325.
template <class T>
[[nodiscard]] constexpr FluxAndCurrent<T> predict(const FluxTorqueEstimator<T>& estimator,
                                                  const FluxAndCurrent<T>& now, SpaceVector<T> u_s,
                                                  T dt) noexcept {
  const auto ahead = [&](const FluxAndCurrent<T>& slope_at, T time) {
    const CurrentModel<T>& model = estimator.current_model();
    const SpaceVector<T> u_minus_ri = u_s - estimator.machine().r_s * slope_at.i_s;
    const SpaceVector<T> psi_r = model.psi_r_from(slope_at.psi_s, slope_at.i_s);
    const SpaceVector<T> slope =
        model.current_derivative(u_minus_ri, psi_r, slope_at.i_s, estimator.omega_m());
    return FluxAndCurrent<T>{now.psi_s + time * u_minus_ri, now.i_s + time * slope};
  };
  return ahead(ahead(now, T(0.5) * dt), dt);
}

}  // namespace sextant
