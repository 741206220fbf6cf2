#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/safety/winding_temperature.hpp"

namespace sextant {

/// Limits of the protections. The defaults suit the paper's machine at 530 V and 25 µs.
template <class T = double>
struct ProtectionLimits {
  T over_current{T(200)};      ///< of any phase current's magnitude [A]
  T dc_over_voltage{T(700)};   ///< of the DC link [V]
  T over_speed{T(487)};        ///< of the mechanical speed's magnitude [rad/s]
  T dc_under_voltage{T(265)};  ///< of the DC link while the gates are driven [V]

  T current_range{T(2000)};  ///< largest magnitude that a current sensor can read [A]
  T voltage_range{T(7000)};  ///< of the sensor of the DC link [V]
  T speed_range{T(4870)};    ///< of the speed sensor [rad/s]

  T current_sum{T(6)};                ///< sum of the phase currents, beside the tolerance of their gains [A]
  T current_gain_tolerance{T(0.05)};  ///< of the sum, as a share of the largest phase current [-]
  T current_offset{T(0.58)};          ///< offset of a phase current, also the most that is removed [A]
  T current_jump{T(8)};               ///< change of a phase current that no voltage explains [A]
  T current_response{T(0.35)};        ///< smallest response of a phase current to the voltage [-]
  T current_noise{T(0.2)};            ///< standard deviation of a measured phase current [A]
  T zero_current{T(2)};               ///< reading of a phase without current [A]
  T current_step{T(0)};               ///< of the current converters; 0: none [A]

  T speed_jump{T(35)};                     ///< change of the speed in one period [rad/s]
  T speed_error{T(28)};                    ///< against the speed by voltages and currents [rad/s]
  std::int64_t speed_error_ns{4'000'000};  ///< such an error for longer is a fault [ns]

  T flux_lost_share{T(0.5)};               ///< smallest flux under torque, as a share of its reference [-]
  T flux_lost_torque{T(7.5)};              ///< smallest torque reference that needs the flux [N·m]
  std::int64_t flux_lost_ns{200'000'000};  ///< less flux for longer is a fault [ns]

  T winding_warning{T(130)};  ///< from here on less torque is available [°C]
  T winding_trip{T(155)};     ///< no torque is available, and a fault [°C]

  typename WindingTemperature<T>::Parameters winding{};
  InductionMachineParameters<T> machine{};           ///< the controller's parameters of the machine
  typename InverterModel<T>::Parameters inverter{};  ///< what makes the voltage of the patterns
  std::int32_t period_ns{25'000};                    ///< control period [ns]

  [[nodiscard]] const char* validate() const noexcept {
    const auto positive = [](T x) { return std::isfinite(x) && x > T(0); };
    if (!positive(over_current)) return "the current trip must be above zero";
    if (!positive(dc_over_voltage)) return "the DC-link voltage trip must be above zero";
    if (!positive(over_speed)) return "the speed trip must be above zero";
    if (!(dc_under_voltage >= T(0) && dc_under_voltage < dc_over_voltage)) {
      return "the DC-link under-voltage trip must be from zero to below the over-voltage trip";
    }
    if (!(current_range > over_current)) return "the range of the currents must be above their trip";
    if (!(voltage_range > dc_over_voltage)) return "the range of the link voltage must be above its trip";
    if (!(speed_range > over_speed)) return "the range of the speed must be above its trip";
    if (!positive(current_sum)) return "the limit of the sum of currents must be above zero";
    if (!(current_gain_tolerance >= T(0) && current_gain_tolerance < T(1))) {
      return "the tolerance of the current gains must be from 0 to below 1";
    }
    if (!positive(current_offset)) return "the limit of a current's offset must be above zero";
    if (!positive(current_jump)) return "the limit of a current's jump must be above zero";
    if (!(current_response >= T(0) && current_response < T(1))) {
      return "the smallest response of a current must be from 0 to below 1";
    }
    if (!positive(current_noise)) return "the noise of the currents must be above zero";
    if (!positive(zero_current)) return "the reading of a phase without current must be above zero";
    if (!(std::isfinite(current_step) && current_step >= T(0))) {
      return "the step of the current converters must not be below zero";
    }
    if (!positive(speed_jump)) return "the limit of the speed's jump must be above zero";
    if (!positive(speed_error)) return "the limit of the speed's error must be above zero";
    if (speed_error_ns <= 0) return "an error of the speed needs a time above zero";
    if (!(flux_lost_share >= T(0) && flux_lost_share < T(1))) {
      return "the smallest share of flux must be from 0 to below 1";
    }
    if (!positive(flux_lost_torque)) return "the torque that needs the flux must be above zero";
    if (flux_lost_ns <= 0) return "lost flux needs a time above zero";
    if (!(std::isfinite(winding_trip) && winding_trip > winding_warning)) {
      return "the winding's trip must be above its warning";
    }
    if (!(winding_warning > winding.ambient)) return "the winding's warning must be above the ambient";
    if (const char* problem = winding.validate()) return problem;
    if (const char* problem = machine.validate()) return problem;
    if (period_ns <= 0) return "the control period must be above zero";
    return inverter.validate(period_ns);
  }
};

}  // namespace sextant
