#pragma once

#include <cmath>

#include "sextant/drive/steady_state.hpp"

namespace sextant {

/// Default limits of a drive from its machine, flux reference and DC link. The factors are chosen; with the
/// paper's machine, 1.1 Wb and 530 V they come near the values of its scenarios.
template <class T = double>
struct DriveLimits {
  T torque{};               ///< largest torque of a command: 0.4 T_b [N·m]
  T torque_band{};          ///< of each torque relay: 0.0025 T_b [N·m]
  T flux_band{};            ///< of the flux relay: 0.01 ψ_ref [Wb]
  T magnetising_current{};  ///< limit while the flux is built up: 3 ψ_ref/L_s [A]
  T hand_over_current{};    ///< at which torque control starts: 2.3 ψ_ref/L_s [A]
  T over_current{};         ///< trip level: 1.25 times the current at the breakdown torque [A]
  T dc_over_voltage{};      ///< trip level: 1.3 u_dc [V]
  T over_speed{};           ///< trip level: 1.2 times the speed of `zero_torque_speed` [rad/s]
};

/// flux_reference is a stator flux linkage [Wb], u_dc the nominal voltage of the link [V].
template <class T>
[[nodiscard]] DriveLimits<T> drive_limits(const InductionMachineParameters<T>& machine, T flux_reference,
                                          T u_dc) noexcept {
  const SteadyState<T> rest = steady_state(machine, flux_reference, T(0));
  const SteadyState<T> breakdown = steady_state(machine, flux_reference, T(1));
  return {.torque = T(0.4) * breakdown.torque,
          .torque_band = T(0.0025) * breakdown.torque,
          .flux_band = T(0.01) * flux_reference,
          .magnetising_current = T(3) * rest.i_d,
          .hand_over_current = T(2.3) * rest.i_d,
          .over_current = T(1.25) * breakdown.current(),
          .dc_over_voltage = T(1.3) * u_dc,
          .over_speed = T(1.2) * zero_torque_speed(machine, flux_reference, u_dc)};
}

}  // namespace sextant
