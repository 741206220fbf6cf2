#pragma once

#include <cstdint>

namespace sextant {

/// How a periodic task waits for its deadline.
enum class WaitMode : std::uint8_t {
  sleep,  ///< clock_nanosleep: the processor is free, the kernel's wake-up latency counts
  spin,   ///< reads the clock until it is time: no system call, takes a processor of its own
  hybrid  ///< sleeps until a margin before the deadline, then spins
};

[[nodiscard]] constexpr const char* to_string(WaitMode mode) noexcept {
  switch (mode) {
    case WaitMode::sleep:
      return "sleep";
    case WaitMode::spin:
      return "spin";
    case WaitMode::hybrid:
      return "hybrid";
  }
  return "";
}

/// Parameters of waiting.
struct WaitParameters {
  WaitMode mode{WaitMode::sleep};
  std::int64_t spin_margin_ns{50'000};  ///< hybrid: how long before the deadline the sleep ends [ns]
  /// Time from a deadline to the next whole multiple of the wake period on CLOCK_MONOTONIC, where the kernel
  /// has its timer ticks; 0: the grid begins at the start. [ns]
  std::int64_t tick_lead_ns{0};
};

}  // namespace sextant
