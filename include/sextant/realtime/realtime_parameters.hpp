#pragma once

#include <cstdint>

namespace sextant {

/// How the control thread wakes and what it asks of the operating system.
struct RealtimeParameters {
  int wake_every_periods{
      40};                 ///< control periods run at each wake-up; above 1 for an in-process plant only [-]
  bool required{false};    ///< refuse to start without the rights, instead of reporting it
  int priority{80};        ///< SCHED_FIFO priority of the control thread, 1…98 [-]
  int cpu{-1};             ///< the CPU it is bound to, or -1 for any [-]
  bool lock_memory{true};  ///< keep all memory resident, so that no page fault stops the control thread

  std::int64_t watchdog_ns{100'000'000};  ///< without a wake-up for so long the watchdog opens the gates [ns]

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (wake_every_periods < 1) return "a wake-up must run at least one control period";
    // 99 is left to the kernel's own threads and to the watchdog of last resort.
    if (priority < 1 || priority > 98) return "the priority must be from 1 to 98";
    if (cpu < -1) return "the CPU must be a number from 0, or -1 for any";
    if (watchdog_ns <= 0) return "the watchdog needs a time above zero";
    return nullptr;
  }
};

}  // namespace sextant
