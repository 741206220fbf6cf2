#pragma once

#include <algorithm>
#include <cmath>

namespace sextant {

/// Moves towards a target at a limited rate.
template <class T = double>
class SetpointRamp {
 public:
  /// Moves towards target by at most max_change; returns the new value.
  constexpr T step(T target, T max_change) noexcept {
    const T rest = target - value_;
    // The target itself, so that no rounding error remains.
    value_ = std::abs(rest) <= max_change ? target : value_ + std::copysign(max_change, rest);
    return value_;
  }

  /// Moves into [lowest, highest] at once; returns the new value.
  constexpr T limit(T lowest, T highest) noexcept { return value_ = std::clamp(value_, lowest, highest); }

  [[nodiscard]] constexpr T value() const noexcept { return value_; }
  constexpr void reset() noexcept { value_ = T(0); }

 private:
  T value_{};
};

}  // namespace sextant
