#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The arithmetic of a periodic task: deadlines on a fixed grid
///   deadline_k = origin + k · wake_period,  wake_period = wake_every_periods · period,
/// and the reaction to a late wake-up. It reads no clock; time is an argument.
///
/// A wake-up that comes one whole wake period or more after its deadline is an overrun. It counts
/// once for any number of wake periods; the whole ones are missed, so that the next deadline is on the grid
/// and the phase is kept. A wake-up that is late by less than a wake period catches up.
class WakeSchedule {
 public:
  struct Parameters {
    std::int64_t period_ns{25'000};  ///< control period [ns]
    int wake_every_periods{40};      ///< control periods run at each wake-up [-]

    [[nodiscard]] constexpr std::int64_t wake_period_ns() const noexcept {
      return period_ns * wake_every_periods;
    }
    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (wake_every_periods < 1) return "a wake-up must run at least one control period";
      return nullptr;
    }
  };

  /// One wake-up.
  struct Wake {
    std::int64_t deadline_ns{};     ///< the newest deadline that has passed: the one this wake-up serves [ns]
    std::int64_t latency_ns{};      ///< from the deadline of the wait to the wake-up, at least 0 [ns]
    std::int64_t periods_missed{};  ///< control periods missed by this wake-up [-]

    [[nodiscard]] constexpr bool overrun() const noexcept { return periods_missed > 0; }
    friend constexpr bool operator==(const Wake&, const Wake&) noexcept = default;
  };

  /// Counts since the start.
  struct Counters {
    std::uint64_t wakes{};              ///< wake-ups, late ones included [-]
    std::uint64_t overruns{};           ///< late wake-ups that missed periods [-]
    std::uint64_t periods_missed{};     ///< control periods missed [-]
    std::uint32_t overruns_in_a_row{};  ///< overruns since the last wake-up in time [-]
  };

  explicit constexpr WakeSchedule(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// The first instant from now_ns on that lies lead_ns before a whole multiple of the wake period [ns].
  [[nodiscard]] static constexpr std::int64_t origin_before_tick(std::int64_t now_ns, std::int64_t lead_ns,
                                                                 std::int64_t wake_period_ns) noexcept {
    const std::int64_t beyond = (now_ns + lead_ns) % wake_period_ns;
    return beyond == 0 ? now_ns : now_ns + wake_period_ns - beyond;
  }

  /// Lays the grid through origin_ns [ns]; the first deadline is one wake period later.
  constexpr void start(std::int64_t origin_ns) noexcept SEXTANT_NONBLOCKING {
    counters_ = {};
    next_deadline_ns_ = origin_ns + parameters_.wake_period_ns();
  }

  /// The next deadline. [ns]
  [[nodiscard]] constexpr std::int64_t next_deadline_ns() const noexcept SEXTANT_NONBLOCKING {
    return next_deadline_ns_;
  }

  /// To be called once a wake-up, with the time at which it came [ns].
  constexpr Wake wake(std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t period = parameters_.wake_period_ns();
    const std::int64_t latency = now_ns > next_deadline_ns_ ? now_ns - next_deadline_ns_ : 0;
    const std::int64_t missed = latency / period;
    const Wake result{next_deadline_ns_ + missed * period, latency, missed * parameters_.wake_every_periods};
    next_deadline_ns_ = result.deadline_ns + period;
    count(result);
    return result;
  }

  [[nodiscard]] constexpr const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }
  [[nodiscard]] constexpr const Parameters& parameters() const noexcept SEXTANT_NONBLOCKING {
    return parameters_;
  }

 private:
  constexpr void count(const Wake& w) noexcept {
    ++counters_.wakes;
    counters_.periods_missed += static_cast<std::uint64_t>(w.periods_missed);
    counters_.overruns += w.overrun() ? 1U : 0U;
    counters_.overruns_in_a_row = w.overrun() ? counters_.overruns_in_a_row + 1U : 0U;
  }

  Parameters parameters_;
  std::int64_t next_deadline_ns_{};
  Counters counters_{};
};

}  // namespace sextant
