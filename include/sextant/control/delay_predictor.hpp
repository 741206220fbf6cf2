#pragma once

#include "sextant/control/flux_torque_estimator.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// Stator flux and current at one instant.
template <class T = double>
struct FluxAndCurrent {
  SpaceVector<T> psi_s{};  ///< [Wb]
  SpaceVector<T> i_s{};    ///< [A]
};

/// Predicts ψ_s and i_s at the end of the pattern in flight, by the machine model and one Euler step per
/// segment. A controller whose pattern is applied one period late decides on the prediction.
/// Source: P. Cortés et al., "Delay compensation in model predictive current control of a three-phase
/// inverter", IEEE Trans. Ind. Electron. 59 (2012) 1323–1325.
template <class T>
[[nodiscard]] constexpr FluxAndCurrent<T> predict(const FluxTorqueEstimator<T>& estimator, T u_dc, T omega_m,
                                                  const GatePattern& in_flight) noexcept {
  FluxAndCurrent<T> x{estimator.psi_s(), estimator.i_s()};
  for (const GateSegment& segment : in_flight.segments()) {
    if (!is_driven(segment.state)) return x;
    const T dt = T(segment.duration_ns) * T(1e-9);
    const SpaceVector<T> u_minus_ri = stator_voltage(segment.state, u_dc) - estimator.machine().r_s * x.i_s;
    const CurrentModel<T>& model = estimator.current_model();
    const SpaceVector<T> psi_r = model.psi_r_from(x.psi_s, x.i_s);
    const SpaceVector<T> di = model.current_derivative(u_minus_ri, psi_r, x.i_s, omega_m);
    x.psi_s += dt * u_minus_ri;
    x.i_s += dt * di;
  }
  return x;
}

}  // namespace sextant
