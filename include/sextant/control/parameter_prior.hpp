#pragma once

#include <algorithm>

namespace sextant {

/// How far R_s, R_r and an inductance may be from their configured values: standard deviations and bounds, as
/// shares of these. R_s and R_r change with temperature by 0.4 % a kelvin.
template <class T>
struct ParameterPrior {
  static constexpr T r_s_deviation{T(0.5)};
  static constexpr T r_r_deviation{T(0.25)};
  static constexpr T l_deviation{T(0.15)};
  /// Deviation that R_s and R_r have in common, because winding and cage warm together: some 40 K.
  static constexpr T warming{T(0.16)};
  static constexpr T gain_error{T(0.03)};  ///< of currents and voltages
  static constexpr T lowest{T(0.3)};
  static constexpr T highest{T(2.5)};

  [[nodiscard]] static constexpr T bounded(T value, T configured) noexcept {
    return std::clamp(value, lowest * configured, highest * configured);
  }
  /// Within the bounds and not at one, where a search ends that only they have stopped.
  [[nodiscard]] static constexpr bool allows(T value, T configured) noexcept {
    constexpr T rounding{T(1e-3)};
    return value > (T(1) + rounding) * lowest * configured &&
           value < (T(1) - rounding) * highest * configured;
  }
};

}  // namespace sextant
