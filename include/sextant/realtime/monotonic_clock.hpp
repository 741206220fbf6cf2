#pragma once

#include <cstdint>

#include <time.h>

namespace sextant {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

/// The drive's clock: CLOCK_MONOTONIC, which no change of the wall clock moves. [ns]
[[nodiscard]] inline std::int64_t now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * ns_per_s + t.tv_nsec;
}

}  // namespace sextant
