#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/controller.hpp"
#include "sextant/drive/anti_jerk.hpp"
#include "sextant/drive/link_voltage_band.hpp"
#include "sextant/drive/motor_control.hpp"
#include "sextant/safety/command_supervision.hpp"
#include "sextant/safety/protection.hpp"
#include "sextant/safety/torque_monitor.hpp"

namespace sextant {

/// Parameters of a `Drive`.
template <class T, class Motor>
  requires MotorControl<Motor, T>
struct DriveParameters {
  std::int32_t period_ns{25'000};                    ///< control period [ns]
  std::int32_t sampling_lead_ns{0};                  ///< from the sample of the currents to the period [ns]
  bool magnetise_first{true};                        ///< build up the flux in MAGNETISING before torque [-]
  std::int64_t magnetise_timeout_ns{1'000'000'000};  ///< MAGNETISING for longer is a fault [ns]
  typename CommandSupervision<T>::Parameters command{};
  typename Protection<T>::Parameters protection{};
  typename Motor::Parameters motor{};
  typename LinkVoltageBand<T>::Parameters low_voltage{};   ///< for motoring
  typename LinkVoltageBand<T>::Parameters high_voltage{};  ///< for regenerating
  typename TorqueMonitor<T>::Parameters torque_monitor{};
  AntiJerkParameters<T> anti_jerk{};  ///< none by default
  T ready_voltage{};                  ///< of the link, below which STANDBY lasts while the gates are off [V]

  [[nodiscard]] const char* validate() const noexcept {
    if (period_ns <= 0) return "the control period must be above zero";
    if (sampling_lead_ns < 0 || sampling_lead_ns > period_ns) {
      return "the sampling lead must be from zero to the control period";
    }
    if (magnetise_timeout_ns <= 0) return "the time for magnetising must be above zero";
    if (const char* problem = command.validate()) return problem;
    if (const char* problem = protection.validate()) return problem;
    if (const char* problem = motor.validate(timing())) return problem;
    if (const char* problem = validate_bands()) return problem;
    if (const char* problem = torque_monitor.validate()) return problem;
    if (const char* problem = anti_jerk.validate()) return problem;
    const T period_s = T(period_ns) * T(1e-9);
    if (const char* problem = anti_jerk.validate_with(motor.inertia(), period_s)) return problem;
    // Protections that count periods of another length would be silent.
    return protection.period_ns == period_ns ? nullptr
                                             : "the control periods of drive and protections differ";
  }

  /// The bands of the link voltage lie between its trip levels.
  [[nodiscard]] const char* validate_bands() const noexcept {
    if (const char* problem = low_voltage.validate()) return problem;
    if (const char* problem = high_voltage.validate()) return problem;
    if (!(ready_voltage >= T(0) && std::isfinite(ready_voltage)))
      return "the link voltage from which on the drive is ready must be finite and not below zero";
    if (low_voltage.is_wrong_below(protection.dc_under_voltage)) {
      return "the link voltage without motoring torque must be from the under-voltage trip to below that "
             "from which on it is whole";
    }
    if (high_voltage.is_wrong_above(protection.dc_over_voltage)) {
      return "the link voltage without regenerating torque must be from above that up to which it is whole "
             "to the over-voltage trip";
    }
    return nullptr;
  }

  /// The same, and whether these parts of the motor suit it: of an `InductionMotor` the controller.
  template <class... Parts>
  [[nodiscard]] const char* validate(const Parts&... parts) const noexcept
    requires(sizeof...(Parts) > 0)
  {
    if (const char* problem = validate()) return problem;
    return motor.validate_with(timing(), parts...);
  }

  [[nodiscard]] ControlTiming timing() const noexcept { return {period_ns, sampling_lead_ns}; }
};

}  // namespace sextant
