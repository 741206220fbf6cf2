#pragma once

#include <cstdint>

#include "sextant/core/description.hpp"

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

inline void describe(Description& d, WaitParameters& p) {
  auto& [mode, spin_margin_ns, tick_lead_ns] = p;
  d.choice("wait", mode, {{"sleep", WaitMode::sleep}, {"spin", WaitMode::spin}, {"hybrid", WaitMode::hybrid}},
           "how the control thread waits for its deadline");
  d.time("spin_margin_us", spin_margin_ns,
         in_us(0, 1e5, "hybrid: how long before the deadline the sleep ends"));
  d.time("tick_lead_us", tick_lead_ns,
         in_us(0, 1e5, "time from a deadline to the kernel's next timer tick; 0: any"));
}

}  // namespace sextant
