#pragma once

#include <cmath>

namespace sextant {

/// Trip levels of the protections.
template <class T = double>
struct ProtectionLimits {
  T over_current{T(200)};     ///< of any phase current's magnitude [A]
  T dc_over_voltage{T(700)};  ///< of the DC link [V]
  T over_speed{T(167)};       ///< of the mechanical speed's magnitude [rad/s]

  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(over_current) && over_current > T(0))) return "the current trip must be above zero";
    if (!(std::isfinite(dc_over_voltage) && dc_over_voltage > T(0))) {
      return "the DC-link voltage trip must be above zero";
    }
    if (!(std::isfinite(over_speed) && over_speed > T(0))) return "the speed trip must be above zero";
    return nullptr;
  }
};

}  // namespace sextant
