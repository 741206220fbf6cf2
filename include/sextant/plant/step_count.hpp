#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A segment that needs more steps than this is not integrated: the machine is too stiff for the method.
inline constexpr std::int64_t most_steps = 10'000'000;

/// The least number of equal steps that divides duration_ns [ns] into pieces of at most max_step_ns [ns].
[[nodiscard]] constexpr std::int64_t steps_of(std::int64_t duration_ns,
                                              std::int64_t max_step_ns) noexcept SEXTANT_NONBLOCKING {
  return duration_ns <= max_step_ns ? 1 : (duration_ns + max_step_ns - 1) / max_step_ns;
}

/// Steps of a segment for a plant that needs at least `demanded`; 0: more than allowed.
template <class T>
[[nodiscard]] std::int64_t at_least(std::int64_t steps, T demanded) noexcept SEXTANT_NONBLOCKING {
  if (!(demanded <= T(most_steps))) return 0;
  return std::max(steps, std::int64_t{std::int32_t(std::ceil(demanded))});  // most_steps fits into 32 bits
}

}  // namespace sextant
