#pragma once

#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/drive/torque_capability.hpp"

namespace sextant {

/// What a user may say of `TorqueCapability`.
template <class T = double>
struct CapabilitySetup {
  using Parameters = typename TorqueCapability<T>::Parameters;

  std::optional<T> torque{};  ///< [N·m]
  T voltage_use{Parameters{}.voltage_use};
  T breakdown_use{Parameters{}.breakdown_use};
  T base_speed{Parameters{}.base_speed};
  T zero_torque_speed{Parameters{}.zero_torque_speed};
  std::optional<T> low_voltage{};        ///< of the link: `full` of the band for motoring [V]
  std::optional<T> low_voltage_zero{};   ///< `zero` of it [V]
  std::optional<T> high_voltage{};       ///< the same for regenerating [V]
  std::optional<T> high_voltage_zero{};  ///< [V]
  std::optional<T> ready_voltage{};      ///< of the link, `ready_voltage` of the drive [V]
};

/// resolved: of `TorqueCapability`.
template <class T, class Parameters>
void describe(Description& d, CapabilitySetup<T>& setup, const Parameters& resolved) {
  auto& [torque, voltage_use, breakdown_use, base_speed, zero_torque_speed, low_voltage, low_voltage_zero,
         high_voltage, high_voltage_zero, ready_voltage] = setup;
  d.derived("torque_nm", torque, resolved.torque,
            {"N·m", 1e-3, 1e5, "largest available torque", Changes::always});
  d.number("voltage_use", voltage_use,
           {"", 0.1, 1.1026,
            "share of u_dc/sqrt(3) that a torque may need; above 1, to six-step, for a modulated method with "
            "overmodulation \"fundamental\"",
            Changes::always});
  d.number(
      "breakdown_use", breakdown_use,
      {"", 0.1, 1, "share of the breakdown torque, at the flux that the voltage allows, that may be used",
       Changes::always});
  d.number("base_speed_rad_s", NumberMember::unless_infinite(base_speed),
           {"rad/s", 1e-3, 1e4, "from it on the motoring torque falls linearly; not set: no such curve",
            Changes::always});
  d.number("zero_torque_speed_rad_s", NumberMember::unless_infinite(zero_torque_speed),
           {"rad/s", 1e-3, 1e4, "from it on there is no motoring torque; not set: no such curve",
            Changes::always});
  d.number(
      "low_voltage_v", low_voltage,
      {"V", 1, 2e4,
       "link voltage below which the available motoring torque falls linearly (DC_LINK_LOW); not set: it "
       "does not",
       Changes::always});
  d.number("low_voltage_zero_v", low_voltage_zero,
           {"V", 1, 2e4,
            "link voltage at which that is zero; not set: three quarters of the way to "
            "protection.dc_under_voltage_v",
            Changes::always});
  d.number("high_voltage_v", high_voltage,
           {"V", 1, 2e4,
            "link voltage above which the available regenerating torque falls linearly (DC_LINK_HIGH); not "
            "set: it does not",
            Changes::always});
  d.number("high_voltage_zero_v", high_voltage_zero,
           {"V", 1, 2e4,
            "link voltage at which that is zero; not set: three quarters of the way to "
            "protection.dc_over_voltage_v",
            Changes::always});
  d.number("ready_voltage_v", ready_voltage,
           {"V", 1, 2e4,
            "link voltage below which the drive waits in STANDBY while its gates are off (DC_LINK_LOW); not "
            "set: low_voltage_zero_v, or protection.dc_under_voltage_v where there is no such band",
            Changes::always});
}

}  // namespace sextant
