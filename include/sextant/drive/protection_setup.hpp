#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/safety/protection_limits.hpp"

namespace sextant {

/// What a user may say of `ProtectionLimits`.
template <class T = double>
struct ProtectionSetup {
  std::optional<T> over_current{};      ///< [A]
  std::optional<T> dc_over_voltage{};   ///< [V]
  std::optional<T> over_speed{};        ///< [rad/s]
  std::optional<T> dc_under_voltage{};  ///< [V]

  std::optional<T> current_range{};  ///< [A]
  std::optional<T> voltage_range{};  ///< [V]
  std::optional<T> speed_range{};    ///< [rad/s]

  std::optional<T> current_sum{};  ///< [A]
  T current_gain_tolerance{ProtectionLimits<T>{}.current_gain_tolerance};
  std::optional<T> current_offset{};  ///< [A]
  std::optional<T> current_jump{};    ///< [A]
  T current_response{ProtectionLimits<T>{}.current_response};
  std::optional<T> current_noise{};  ///< [A]
  std::optional<T> zero_current{};   ///< [A]
  std::optional<T> current_step{};   ///< [A]

  std::optional<T> speed_jump{};   ///< [rad/s]
  std::optional<T> speed_error{};  ///< [rad/s]
  std::int64_t speed_error_ns{ProtectionLimits<T>{}.speed_error_ns};

  T flux_lost_share{ProtectionLimits<T>{}.flux_lost_share};
  std::optional<T> flux_lost_torque{};  ///< [N·m]
  std::int64_t flux_lost_ns{ProtectionLimits<T>{}.flux_lost_ns};

  T winding_warning{ProtectionLimits<T>{}.winding_warning};
  T winding_trip{ProtectionLimits<T>{}.winding_trip};
  typename WindingTemperature<T>::Parameters winding{};
};

template <class T>
void describe(Description& d, ProtectionSetup<T>& setup, const ProtectionLimits<T>& resolved) {
  auto& [over_current, dc_over_voltage, over_speed, dc_under_voltage, current_range, voltage_range,
         speed_range, current_sum, current_gain_tolerance, current_offset, current_jump, current_response,
         current_noise, zero_current, current_step, speed_jump, speed_error, speed_error_ns, flux_lost_share,
         flux_lost_torque, flux_lost_ns, winding_warning, winding_trip, winding] = setup;
  d.derived("over_current_a", over_current, resolved.over_current,
            {"A", 0.1, 1e5, "largest magnitude of a measured phase current; more is OVER_CURRENT",
             Changes::always});
  d.derived("dc_over_voltage_v", dc_over_voltage, resolved.dc_over_voltage,
            {"V", 1, 2e4, "largest voltage of the DC link; more is DC_OVER_VOLTAGE", Changes::always});
  d.derived(
      "over_speed_rad_s", over_speed, resolved.over_speed,
      {"rad/s", 1e-3, 1e4, "largest magnitude of the mechanical speed; more is OVER_SPEED", Changes::always});
  d.derived(
      "dc_under_voltage_v", dc_under_voltage, resolved.dc_under_voltage,
      {"V", 0, 2e4, "smallest voltage of the DC link while the gates are driven; less is DC_UNDER_VOLTAGE",
       Changes::always});
  // A reading beyond them comes from no sensor: a broken converter or link.
  d.derived("current_range_a", current_range, resolved.current_range,
            {"A", 1e-3, 1e7, "largest magnitude that a current sensor can read; more is MEASUREMENT_INVALID",
             Changes::always});
  d.derived(
      "voltage_range_v", voltage_range, resolved.voltage_range,
      {"V", 1, 2e5, "largest voltage of the DC link that its sensor can read; more is MEASUREMENT_INVALID",
       Changes::always});
  d.derived(
      "speed_range_rad_s", speed_range, resolved.speed_range,
      {"rad/s", 1e-3, 1e5, "largest magnitude that the speed sensor can read; more is MEASUREMENT_INVALID",
       Changes::always});
  d.derived("current_sum_a", current_sum, resolved.current_sum,
            {"A", 1e-6, 1e9,
             "largest magnitude of the sum of the phase currents, plus current_gain_tolerance of the largest "
             "of them; more in three control periods is CURRENT_SUM",
             Changes::always});
  d.number("current_gain_tolerance", current_gain_tolerance,
           {"", 0, 0.99,
            "errors of the current sensors' gains, as a share of the largest phase current: added to "
            "current_sum_a",
            Changes::always});
  d.derived("current_offset_a", current_offset, resolved.current_offset,
            {"A", 1e-6, 1e9,
             "largest offset of a phase current's sensor, its mean reading with the gates off: removed from "
             "the controller's currents, allowed for by the torque monitor; a larger one is CURRENT_SENSOR",
             Changes::always});
  d.derived(
      "current_jump_a", current_jump, resolved.current_jump,
      {"A", 1e-6, 1e9,
       "largest change of a phase current in a control period beside that by the voltage; more, twice in a "
       "row, is CURRENT_SENSOR; by half of it the model may move currents whose readings stand still",
       Changes::always});
  d.number("current_response", current_response,
           {"", 0, 0.99,
            "smallest measured change of a phase current, as a share of that by the machine's parameters, "
            "over 3 ms; less is CURRENT_SENSOR, or OPEN_PHASE at zero_current_a; 0: neither",
            Changes::always});
  d.derived("current_noise_a", current_noise, resolved.current_noise,
            {"A", 1e-6, 1e9,
             "standard deviation of the noise of a measured phase current: the larger, the more switching "
             "the response needs before it counts",
             Changes::always});
  d.derived("zero_current_a", zero_current, resolved.zero_current,
            {"A", 1e-6, 1e9,
             "largest reading of a phase without current; a phase that stays below it and does not respond "
             "is OPEN_PHASE",
             Changes::always});
  d.derived("current_step_a", current_step, resolved.current_step,
            {"A", 0, 1e5,
             "step of the current sensors' converter: readings that differ by no more are equal; 0: none",
             Changes::always});
  d.derived("speed_jump_rad_s", speed_jump, resolved.speed_jump,
            {"rad/s", 1e-3, 1e4,
             "largest change of the measured speed in a control period while the gates are driven; more is "
             "SPEED_SENSOR",
             Changes::always});
  d.derived("speed_error_rad_s", speed_error, resolved.speed_error,
            {"rad/s", 1e-3, 1e4,
             "largest difference of the measured speed and that by voltages and currents, beside the slip; "
             "more for speed_error_ms is SPEED_SENSOR",
             Changes::always});
  d.time(
      "speed_error_ms", speed_error_ns,
      in_ms(0.1, 1e4, "time for which the speed may differ by more than speed_error_rad_s", Changes::always));
  d.number("flux_lost_share", flux_lost_share,
           {"", 0, 0.99,
            "smallest estimated stator flux while flux_lost_torque_nm is exceeded, as a share of its "
            "reference; less for flux_lost_ms is FLUX_LOST; 0: never",
            Changes::always});
  d.derived("flux_lost_torque_nm", flux_lost_torque, resolved.flux_lost_torque,
            {"N·m", 1e-6, 1e5, "torque reference above which less flux than flux_lost_share counts as lost",
             Changes::always});
  d.time("flux_lost_ms", flux_lost_ns,
         in_ms(0.1, 1e4, "time for which the flux may be below flux_lost_share", Changes::always));
  d.enter("winding");
  describe(d, winding);
  d.number("warning_c", winding_warning,
           {"C", -100, 500,
            "temperature of the winding from which on the available torque falls, to zero at trip_c",
            Changes::always});
  d.number(
      "trip_c", winding_trip,
      {"C", -100, 500, "temperature of the winding above which there is OVER_TEMPERATURE", Changes::always});
  d.leave();
}

}  // namespace sextant
