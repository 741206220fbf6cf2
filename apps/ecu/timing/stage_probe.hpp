#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "ecu/timing/wake_record.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/cycle_counter.hpp"
#include "sextant/realtime/overrun.hpp"

namespace sextant::ecu {

/// Time stamps of the control thread within its execution, one at the end of each stage, by the processor's
/// counter. Used by the control thread.
class StageProbe {
 public:
  /// gap_limit_ns: two stamps further apart are a gap [ns].
  StageProbe(bool on, std::int64_t gap_limit_ns) noexcept
      : counter_{on ? 5'000'000 : 0}, on_{on}, gap_limit_ns_{gap_limit_ns} {}

  /// At a wake-up: starts a new sequence of stamps.
  void wake() noexcept SEXTANT_NONBLOCKING {
    if (on_) first_ = last_ = counter_.ticks();
  }

  /// The first stage of a period begins.
  void begin() noexcept SEXTANT_NONBLOCKING {
    if (on_) add(step_ns(), GapPlace::between);
  }

  /// The stage ends here; the next begins.
  void end(Stage stage) noexcept SEXTANT_NONBLOCKING {
    if (!on_) return;
    const std::int64_t ns = step_ns();
    add(ns, place_of(stage));
    record_[static_cast<std::size_t>(stage)] =
        static_cast<std::uint32_t>(std::min<std::int64_t>(ns, std::numeric_limits<std::uint32_t>::max()));
  }

  /// At the end of a wake-up's execution, which took execution_ns by the clock [ns]: adds the time that the
  /// stamps do not cover.
  void finish(std::int64_t execution_ns) noexcept SEXTANT_NONBLOCKING {
    if (!on_) return;
    add(step_ns(), GapPlace::between);
    add(execution_ns - counter_.elapsed_ns(first_, last_), GapPlace::between);
  }

  [[nodiscard]] bool on() const noexcept SEXTANT_NONBLOCKING { return on_; }
  /// Of the last period.
  [[nodiscard]] const StageRecord& record() const noexcept SEXTANT_NONBLOCKING { return record_; }
  /// A time between two stamps of the caller. [ns]
  void add(std::int64_t duration_ns, GapPlace where) noexcept SEXTANT_NONBLOCKING {
    gap_.add(duration_ns, where, gap_limit_ns_);
    longest_ns_ = std::max(longest_ns_, duration_ns);
  }

  /// The gaps that can have made a wake-up late, since clear_gap() and less those that fade_gap() removed.
  [[nodiscard]] const Gap& gap() const noexcept SEXTANT_NONBLOCKING { return gap_; }
  void clear_gap() noexcept SEXTANT_NONBLOCKING { gap_ = {}; }
  void fade_gap(std::int64_t latency_ns) noexcept SEXTANT_NONBLOCKING {
    gap_.fade(latency_ns, gap_limit_ns_);
  }

  /// The longest time between two stamps since the last call. [ns]
  [[nodiscard]] std::int64_t take_longest_ns() noexcept SEXTANT_NONBLOCKING {
    return std::exchange(longest_ns_, 0);
  }

 private:
  std::int64_t step_ns() noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t now = counter_.ticks();
    const std::int64_t ns = counter_.elapsed_ns(last_, now);
    last_ = now;
    return ns;
  }

  CycleCounter counter_;
  bool on_;
  std::int64_t gap_limit_ns_;
  std::uint64_t first_{0};
  std::uint64_t last_{0};
  StageRecord record_{};
  Gap gap_{};
  std::int64_t longest_ns_{0};
};

}  // namespace sextant::ecu
