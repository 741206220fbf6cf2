#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sextant {

/// Time from `since_ns` to `t_ns`, saturated: zero where `t_ns` is not later, as on a clock that was set
/// back, and the largest number where the difference exceeds it. [ns]
[[nodiscard]] constexpr std::int64_t elapsed(std::int64_t since_ns, std::int64_t t_ns) noexcept {
  if (t_ns <= since_ns) return 0;
  constexpr std::uint64_t largest = std::numeric_limits<std::int64_t>::max();
  return std::int64_t(std::min(std::uint64_t(t_ns) - std::uint64_t(since_ns), largest));
}

}  // namespace sextant
