#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The stages of a control period, in their order.
enum class Stage : std::uint8_t {
  read,      ///< `DriveIo::read`; a simulated plant is integrated here
  commands,  ///< the newest command is fetched
  drive,     ///< `Drive::step`: protections, command supervision, controller
  write,     ///< `DriveIo::write`
  push       ///< telemetry into its ring
};

inline constexpr std::size_t stage_count = 5;

[[nodiscard]] constexpr const char* to_string(Stage stage) noexcept {
  constexpr std::array names{"read", "commands", "drive", "write", "push"};
  static_assert(names.size() == stage_count);
  return names[static_cast<std::size_t>(stage)];
}

/// The two time stamps of the control thread between which a gap lies. The first values are the stages.
enum class GapPlace : std::uint8_t { read, commands, drive, write, push, between, waiting };

/// The place of a gap within this stage.
[[nodiscard]] constexpr GapPlace place_of(Stage stage) noexcept SEXTANT_NONBLOCKING {
  switch (stage) {
    case Stage::read:
      return GapPlace::read;
    case Stage::commands:
      return GapPlace::commands;
    case Stage::drive:
      return GapPlace::drive;
    case Stage::write:
      return GapPlace::write;
    case Stage::push:
      break;
  }
  return GapPlace::push;
}

[[nodiscard]] constexpr const char* to_string(GapPlace place) noexcept {
  constexpr std::array names{"in read", "in commands",    "in drive",     "in write",
                             "in push", "between stages", "while waiting"};
  static_assert(names.size() == std::size_t(GapPlace::waiting) + 1);
  return names[static_cast<std::size_t>(place)];
}

/// The gaps that can have made a wake-up late: times between two successive time stamps of the control thread
/// above a limit.
struct Gap {
  std::int64_t longest_ns{0};         ///< 0: none [ns]
  GapPlace place{GapPlace::between};  ///< of the longest
  std::int64_t sum_ns{0};             ///< of all [ns]

  /// A time between two stamps [ns]; up to limit_ns [ns] it is no gap.
  constexpr void add(std::int64_t duration_ns, GapPlace where,
                     std::int64_t limit_ns) noexcept SEXTANT_NONBLOCKING {
    if (duration_ns <= limit_ns) return;
    sum_ns += duration_ns;
    if (duration_ns <= longest_ns) return;
    longest_ns = duration_ns;
    place = where;
  }

  /// After a wake-up that was late by latency_ns [ns]: at most that part of the gaps can make the next ones
  /// late, and a part up to limit_ns [ns] none.
  constexpr void fade(std::int64_t latency_ns, std::int64_t limit_ns) noexcept SEXTANT_NONBLOCKING {
    if (sum_ns > latency_ns) sum_ns = latency_ns;
    if (sum_ns <= limit_ns) *this = {};
  }
};

/// Why a wake-up was an overrun.
enum class OverrunCause : std::uint8_t {
  machine_gap,    ///< the machine stopped the thread: a gap between two readings of the clock, or a gap in a
                  ///< stage of which the kernel reports as much waiting for a processor or stolen time
  stage_gap,      ///< a gap in a stage without such a report: the stage itself, a hypervisor or firmware
  late_wake,      ///< the kernel ended the sleep late
  long_execution  ///< no gap accounts for it: the execution took longer than the period
};

inline constexpr std::size_t overrun_cause_count = 4;

[[nodiscard]] constexpr const char* to_string(OverrunCause cause) noexcept {
  constexpr std::array names{"machine gap", "gap in a stage", "late wake-up", "own execution"};
  static_assert(names.size() == overrun_cause_count);
  return names[static_cast<std::size_t>(cause)];
}

/// One overrun.
struct Overrun {
  std::int64_t t_ns{};        ///< the deadline that was missed, on the drive's clock [ns]
  std::int64_t latency_ns{};  ///< from it to the wake-up [ns]
  Gap gap{};                  ///< since the last wake-up in time, or the last overrun
  bool execution_overran{};   ///< the execution before it ended after that deadline
  OverrunCause cause{OverrunCause::long_execution};
};

/// Whether the gaps account for the overrun: without them the wake-up would have been late by less than a
/// wake period (wake_period_ns [ns]), which is no overrun.
[[nodiscard]] constexpr bool gaps_account_for(const Overrun& overrun, std::int64_t wake_period_ns) noexcept {
  return overrun.gap.sum_ns > 0 && overrun.latency_ns - overrun.gap.sum_ns < wake_period_ns;
}

/// The cause by the control thread's own time stamps alone.
[[nodiscard]] constexpr OverrunCause visible_cause(const Overrun& overrun,
                                                   std::int64_t wake_period_ns) noexcept {
  if (gaps_account_for(overrun, wake_period_ns)) {
    return overrun.gap.place == GapPlace::waiting ? OverrunCause::machine_gap : OverrunCause::stage_gap;
  }
  return overrun.execution_overran ? OverrunCause::long_execution : OverrunCause::late_wake;
}

}  // namespace sextant
