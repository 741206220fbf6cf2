#pragma once

#include <cmath>
#include <cstdint>

namespace sextant {

/// A fifth of 1/t_period: the bandwidth of a continuous control method in a period [ns]. [rad/s]
template <class T>
[[nodiscard]] constexpr T default_bandwidth(std::int32_t period_ns) noexcept {
  return T(0.2e9) / T(period_ns);
}

/// nullptr, else what is wrong with a bandwidth [rad/s] in a period [ns]. Half of what leads a quantity to
/// its reference within a period leaves room for a machine with half the leakage inductance.
template <class T>
[[nodiscard]] const char* validate_bandwidth(T bandwidth, std::int32_t period_ns) noexcept {
  if (!(std::isfinite(bandwidth) && bandwidth > T(0)))
    return "the bandwidth of the control must be above zero";
  if (!(bandwidth * T(period_ns) <= T(0.5e9))) {
    return "the bandwidth of the control must be at most 0.5 divided by the control period";
  }
  return nullptr;
}

}  // namespace sextant
