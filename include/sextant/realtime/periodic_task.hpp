#pragma once

#include <cerrno>
#include <cstdint>

#include <time.h>

#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant {

/// Wakes the calling thread on the absolute deadlines of a WakeSchedule. Absolute, so that the time the work
/// takes does not add to the period; clock_nanosleep, because a timerfd is woken from a soft interrupt.
class PeriodicTask {
 public:
  explicit PeriodicTask(const WakeSchedule::Parameters& parameters) noexcept : schedule_{parameters} {}

  /// Lays the grid of deadlines; the first is one wake period from now. Returns the grid's origin. [ns]
  std::int64_t start() noexcept {
    const std::int64_t origin_ns = now_ns();
    schedule_.start(origin_ns);
    return origin_ns;
  }

  /// Sleeps until the next deadline; returns at once where it has passed.
  WakeSchedule::Wake wait() noexcept {
    const std::int64_t deadline_ns = schedule_.next_deadline_ns();
    const timespec until{static_cast<time_t>(deadline_ns / ns_per_s),
                         static_cast<long>(deadline_ns % ns_per_s)};
    // A signal ends the sleep early; the deadline is absolute, so sleeping again costs no drift.
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
    return schedule_.wake(now_ns());
  }

  [[nodiscard]] const WakeSchedule& schedule() const noexcept { return schedule_; }

 private:
  WakeSchedule schedule_;
};

}  // namespace sextant
