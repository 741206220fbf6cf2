#pragma once

#include <algorithm>

namespace sextant {

/// What is known of R_s, R_r and of an inductance before anything is measured: they are as configured within
/// a standard deviation, and certainly within bounds, all as shares of the configured value. The deviations
/// are half of what the drive allows for. R_s and R_r are those of a winding and a cage of unknown
/// temperature.
template <class T>
struct ParameterPrior {
  static constexpr T r_s_deviation{T(0.5)};
  static constexpr T r_r_deviation{T(0.25)};
  static constexpr T l_deviation{T(0.15)};
  /// Deviation that R_s and R_r have in common: winding and cage warm together, by some 40 K at 0.4 % a
  /// kelvin.
  static constexpr T warming{T(0.17)};
  static constexpr T lowest{T(0.3)};
  static constexpr T highest{T(2.5)};

  [[nodiscard]] static constexpr T bounded(T value, T configured) noexcept {
    return std::clamp(value, lowest * configured, highest * configured);
  }
  [[nodiscard]] static constexpr bool allows(T value, T configured) noexcept {
    return value == bounded(value, configured);
  }
};

}  // namespace sextant
