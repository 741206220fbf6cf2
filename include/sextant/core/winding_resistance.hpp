#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/description.hpp"

namespace sextant {

/// What R_s does with the temperature of the winding,
///   R_s(ϑ) = R_s (1 + α (ϑ − ϑ_ref))
/// Of copper α = 1/(235 °C + ϑ_ref): 0.00392/K at 20 °C (IEC 60034-1, 8.6.2.3.3). With α = 0 R_s is constant.
template <class T = double>
struct WindingResistance {
  T per_kelvin{};      ///< α; 0: R_s is constant [1/K]
  T reference{T(20)};  ///< ϑ_ref, the temperature at which the drive's R_s holds [°C]

  [[nodiscard]] constexpr bool varies() const noexcept { return per_kelvin != T(0); }

  /// R_s(ϑ)/R_s, kept from 0.5 to 2, which copper passes at −107 and 275 °C: a sensor that reads nonsense
  /// does not take R_s along. [-]
  [[nodiscard]] constexpr T ratio(T temperature) const noexcept {
    return std::clamp(T(1) + per_kelvin * (temperature - reference), T(0.5), T(2));
  }

  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(per_kelvin) && per_kelvin >= T(0))) {
      return "the temperature coefficient of R_s must be finite and not below zero";
    }
    return std::isfinite(reference) ? nullptr : "the temperature at which R_s holds must be a number";
  }
};

template <class T>
void describe(Description& d, WindingResistance<T>& p) {
  auto& [per_kelvin, reference] = p;
  d.number("r_s_per_k", per_kelvin,
           {"1/K", 0, 0.02,
            "by which R_s in use rises with the winding's temperature, measured or by the thermal model of "
            "[protection.winding], of what it is at r_s_reference_c: copper 0.00393; 0: it does not",
            Changes::when_ready});
  d.number(
      "r_s_reference_c", reference,
      {"C", -100, 200, "temperature at which R_s of [control.machine_estimate] holds", Changes::when_ready});
}

}  // namespace sextant
