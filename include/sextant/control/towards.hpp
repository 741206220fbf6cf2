#pragma once

namespace sextant {

/// The value of a ramp a step later: nearer to the level by the step at most, which is above zero.
template <class T>
[[nodiscard]] constexpr T towards(T level, T value, T step) noexcept {
  if (level > value) return level - value > step ? value + step : level;
  return value - level > step ? value - step : level;
}

}  // namespace sextant
