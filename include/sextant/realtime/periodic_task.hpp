#pragma once

#include <algorithm>
#include <cerrno>
#include <cstdint>

#include <time.h>

#include "sextant/realtime/cpu_relax.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/wait_mode.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant {

/// Wakes the calling thread on the absolute deadlines of a WakeSchedule. Absolute, so that the time the work
/// takes does not add to the period; clock_nanosleep, because a timerfd is woken from a soft interrupt.
///
/// While it spins it reads the clock without a pause: a gap between two readings is time in which the program
/// had no processor.
class PeriodicTask {
 public:
  explicit PeriodicTask(const WakeSchedule::Parameters& parameters, const WaitParameters& wait = {}) noexcept
      : schedule_{parameters}, wait_{wait} {}

  /// Sets the grid of deadlines; the first is one wake period after the call, and up to one more where the
  /// grid follows the kernel's ticks. Returns the grid's origin. [ns]
  std::int64_t start() noexcept {
    std::int64_t origin_ns = now_ns();
    if (wait_.tick_lead_ns > 0) {
      origin_ns = WakeSchedule::origin_before_tick(origin_ns, wait_.tick_lead_ns,
                                                   schedule_.parameters().wake_period_ns());
    }
    schedule_.start(origin_ns);
    return origin_ns;
  }

  /// Waits until the next deadline; returns at once where it has passed.
  WakeSchedule::Wake wait() noexcept {
    const std::int64_t deadline_ns = schedule_.next_deadline_ns();
    began_ns_ = now_ns();
    longest_gap_ns_ = 0;
    std::int64_t woken_ns = began_ns_;
    if (wait_.mode == WaitMode::sleep) woken_ns = sleep_until(deadline_ns);
    if (wait_.mode == WaitMode::hybrid && woken_ns < deadline_ns - wait_.spin_margin_ns) {
      woken_ns = sleep_until(deadline_ns - wait_.spin_margin_ns);
    }
    woken_ns_ = spin_until(deadline_ns, woken_ns);
    return schedule_.wake(woken_ns_);
  }

  [[nodiscard]] const WakeSchedule& schedule() const noexcept { return schedule_; }
  /// When the last wait began and ended. [ns]
  [[nodiscard]] std::int64_t began_ns() const noexcept { return began_ns_; }
  [[nodiscard]] std::int64_t woken_ns() const noexcept { return woken_ns_; }
  /// The longest time between two readings of the clock while the last wait was spinning. [ns]
  [[nodiscard]] std::int64_t longest_gap_ns() const noexcept { return longest_gap_ns_; }

 private:
  [[nodiscard]] static std::int64_t sleep_until(std::int64_t deadline_ns) noexcept {
    const timespec until{static_cast<time_t>(deadline_ns / ns_per_s),
                         static_cast<long>(deadline_ns % ns_per_s)};
    // A signal ends the sleep early; the deadline is absolute, so sleeping again costs no drift.
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
    return now_ns();
  }

  [[nodiscard]] std::int64_t spin_until(std::int64_t deadline_ns, std::int64_t last_ns) noexcept {
    while (last_ns < deadline_ns) {
      cpu_relax();
      const std::int64_t now = now_ns();
      longest_gap_ns_ = std::max(longest_gap_ns_, now - last_ns);
      last_ns = now;
    }
    return last_ns;
  }

  WakeSchedule schedule_;
  WaitParameters wait_;
  std::int64_t began_ns_{0};
  std::int64_t woken_ns_{0};
  std::int64_t longest_gap_ns_{0};
};

}  // namespace sextant
