#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/core/minimum_pulse.hpp"

namespace sextant {

/// The inverter as the drive takes it to be (`InverterModel`). All zero: an ideal inverter.
template <class T = double>
struct InverterParameters {
  std::int32_t dead_time_ns{0};              ///< t_d [ns]
  MinimumPulse::Parameters minimum_pulse{};  ///< none by default
  T threshold_voltage{};                     ///< V_t, of a switch or diode that conducts [V]
  T slope_resistance{};                      ///< r, the same [Ω]
  /// How far the stator voltage along the current may be off, by what is not known of the inverter; a
  /// standard deviation. The model itself does not depend on it. [V]
  T voltage_error{};

  [[nodiscard]] constexpr bool is_ideal() const noexcept {
    return dead_time_ns == 0 && minimum_pulse.duration_ns == 0 && threshold_voltage == T(0) &&
           slope_resistance == T(0);
  }
  /// The voltage error to expect where dead time and threshold are known as data sheets tell them: a tenth
  /// of the fundamental of what both take, u_dc t_d/t_period + V_t with the sign of the current. [V]
  [[nodiscard]] constexpr T likely_voltage_error(std::int32_t period_ns, T u_dc) const noexcept {
    constexpr T fundamental = T(4) / T(std::numbers::pi);
    return T(0.1) * fundamental * (u_dc * T(dead_time_ns) / T(period_ns) + threshold_voltage);
  }
  /// For a control period. [ns]
  [[nodiscard]] const char* validate(std::int32_t period_ns) const noexcept {
    if (dead_time_ns < 0 || dead_time_ns >= period_ns - dead_time_ns) {
      return "the inverter's dead time must be from zero to below half of the control period";
    }
    // Without voltage a leg is high for half of a period, and low at both of its ends for a quarter.
    const std::int32_t pulse_ns = minimum_pulse.duration_ns;
    if (pulse_ns < 0 || pulse_ns >= period_ns / 4) {
      return "the inverter's minimum pulse must be from zero to below a quarter of the control period";
    }
    if (pulse_ns > 0 && pulse_ns < dead_time_ns) {
      return "the inverter's minimum pulse must be zero or at least its dead time: a shorter one turns no "
             "switch on";
    }
    const auto is_usable = [](T x) { return std::isfinite(x) && x >= T(0); };
    if (!is_usable(threshold_voltage)) return "the inverter's threshold voltage must not be below zero";
    if (!is_usable(slope_resistance)) return "the inverter's slope resistance must not be below zero";
    return is_usable(voltage_error) ? nullptr : "the inverter's voltage error must not be below zero";
  }

  /// given: the voltage error, where a user states it; resolved: with the one in force.
  friend void describe(Description& d, InverterParameters& p, std::optional<T>& given,
                       const InverterParameters& resolved) {
    auto& [dead_ns, pulse, threshold, slope, error] = p;
    d.time("dead_time_us", dead_ns,
           in_us(0, 5e4,
                 "time for which both switches of a leg are off where it changes between low and high, as "
                 "the drive takes it: volt-seconds of estimator, identification, predictions, protections "
                 "and torque monitor follow from it, and modulated methods compensate it; 0: an ideal "
                 "inverter",
                 Changes::when_ready));
    describe(d, pulse);
    d.number("threshold_v", threshold,
             {"V", 0, 1e3, "voltage of a switch or diode that conducts, without current; the same uses",
              Changes::when_ready});
    d.number("slope_ohm", slope,
             {"ohm", 0, 1e3,
              "by which the voltage of a conducting switch or diode rises with its current; the same "
              "uses",
              Changes::when_ready});
    d.derived("voltage_error_v", given, resolved.voltage_error,
              {"V", 0, 1e3,
               "what may be unknown of the stator voltage along the current, as a standard deviation: the "
               "lower the stator frequency, the more of the flux follows from the current in its place; "
               "identification, adaptation, speed plausibility and torque monitor allow for it",
               Changes::when_ready});
  }
};

}  // namespace sextant
