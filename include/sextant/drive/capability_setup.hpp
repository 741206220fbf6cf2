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
};

/// resolved: of `TorqueCapability`.
template <class T, class Parameters>
void describe(Description& d, CapabilitySetup<T>& setup, const Parameters& resolved) {
  auto& [torque, voltage_use, breakdown_use, base_speed, zero_torque_speed] = setup;
  d.derived("torque_nm", torque, resolved.torque, {"N·m", 1e-3, 1e5, "largest available torque"});
  d.number("voltage_use", voltage_use,
           {"", 0.1, 1.1026,
            "share of u_dc/sqrt(3) that a torque may need; above 1, to six-step, for a modulated method with "
            "overmodulation \"fundamental\""});
  d.number(
      "breakdown_use", breakdown_use,
      {"", 0.1, 1, "share of the breakdown torque, at the flux that the voltage allows, that may be used"});
  d.number("base_speed_rad_s", NumberMember::unless_infinite(base_speed),
           {"rad/s", 1e-3, 1e4, "from it on the motoring torque falls linearly; not set: no such curve"});
  d.number("zero_torque_speed_rad_s", NumberMember::unless_infinite(zero_torque_speed),
           {"rad/s", 1e-3, 1e4, "from it on there is no motoring torque; not set: no such curve"});
}

}  // namespace sextant
