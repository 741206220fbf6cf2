#pragma once

#include <cmath>

#include "sextant/core/steady_state.hpp"

namespace sextant {

/// Default limits of a drive from its machine, flux reference and DC link. The factors are chosen; with the
/// paper's machine, 1.1 Wb and 530 V they come near the values of its scenarios.
template <class T = double>
struct DriveLimits {
  T torque{};               ///< largest torque of a command: 0.4 T_b [N·m]
  T torque_band{};          ///< of each torque relay: 0.0025 T_b [N·m]
  T flux_band{};            ///< of the flux relay: 0.01 ψ_ref [Wb]
  T magnetising_current{};  ///< limit while the flux is built up: 1.8 ψ_ref/L_s [A]
  T hand_over_current{};    ///< at which torque control starts: 1.25 ψ_ref/L_s [A]
  T over_current{};         ///< trip level: 1.25 times the current at the breakdown torque [A]
  T dc_over_voltage{};      ///< trip level: 1.3 u_dc [V]
  T torque_deviation{};     ///< at which the torque monitor trips: 0.0275 T_b [N·m]
  T current_offset{};       ///< of a phase current's sensor: 0.045 ψ_ref/L_s [A]
  T over_speed{};           ///< trip level: 3.5 times the speed of `zero_torque_speed` [rad/s]
  T dc_under_voltage{};     ///< trip level: 0.5 u_dc [V]
  T speed_jump{};           ///< in one period: 0.25 of that speed [rad/s]
  T speed_error{};          ///< against voltages and currents: 0.2 of that speed [rad/s]
};

/// flux_reference is a stator flux linkage [Wb], u_dc the nominal voltage of the link [V].
template <class T>
[[nodiscard]] DriveLimits<T> drive_limits(const InductionMachineParameters<T>& machine, T flux_reference,
                                          T u_dc) noexcept {
  const SteadyState<T> rest = steady_state(machine, flux_reference, T(0));
  const SteadyState<T> breakdown = steady_state(machine, flux_reference, T(1));
  const T highest_speed = zero_torque_speed(machine, flux_reference, u_dc);
  return {.torque = T(0.4) * breakdown.torque,
          .torque_band = T(0.0025) * breakdown.torque,
          .flux_band = T(0.01) * flux_reference,
          .magnetising_current = T(1.8) * rest.i_d,
          .hand_over_current = T(1.25) * rest.i_d,
          .over_current = T(1.25) * breakdown.current(),
          .dc_over_voltage = T(1.3) * u_dc,
          .torque_deviation = T(0.0275) * breakdown.torque,
          .current_offset = T(0.045) * rest.i_d,
          .over_speed = T(3.5) * highest_speed,
          .dc_under_voltage = T(0.5) * u_dc,
          .speed_jump = T(0.25) * highest_speed,
          .speed_error = T(0.2) * highest_speed};
}

/// Default limits of the current sensors. Their errors are taken to go with the range, and this with the trip
/// level: an offset and six standard deviations of noise are at most 3 % of it.
template <class T = double>
struct CurrentSensorLimits {
  T sum{};           ///< 0.03 of the trip level [A]
  T jump{};          ///< the same, and half of the change by an active vector in one period [A]
  T noise{};         ///< 0.001 of the trip level [A]
  T zero_current{};  ///< 0.01 of the trip level [A]
  T step{};          ///< 0.003 of the trip level: 10 bits over 1.5 times it, both signs [A]
};

/// over_current is the trip level [A], u_dc the nominal voltage of the link [V], period the control period
/// [s].
template <class T>
[[nodiscard]] CurrentSensorLimits<T> current_sensor_limits(const InductionMachineParameters<T>& machine,
                                                           T over_current, T u_dc, T period) noexcept {
  const T active_vector = T(2) / T(3) * u_dc * period / machine.sigma_l_s();
  return {.sum = T(0.03) * over_current,
          .jump = T(0.03) * over_current + T(0.5) * active_vector,
          .noise = T(0.001) * over_current,
          .zero_current = T(0.01) * over_current,
          .step = T(0.003) * over_current};
}

}  // namespace sextant
