#pragma once

#include <algorithm>
#include <cmath>

namespace sextant {

/// Follows a target at no more than a given rate.
template <class T = double>
class SetpointRamp {
 public:
  /// Moves towards target by at most max_change; returns the new value. `limited()` tells whether the
  /// target was out of reach.
  constexpr T step(T target, T max_change) noexcept {
    const T change = std::clamp(target - value_, -max_change, max_change);
    limited_ = change != target - value_;
    value_ = limited_ ? value_ + change : target;
    return value_;
  }

  [[nodiscard]] constexpr T value() const noexcept { return value_; }
  [[nodiscard]] constexpr bool limited() const noexcept { return limited_; }
  constexpr void reset() noexcept {
    value_ = T(0);
    limited_ = false;
  }

 private:
  T value_{};
  bool limited_{false};
};

}  // namespace sextant
