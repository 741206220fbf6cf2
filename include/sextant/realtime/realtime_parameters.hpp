#pragma once

#include <cstdint>

#include "sextant/core/description.hpp"
#include "sextant/realtime/wait_mode.hpp"

namespace sextant {

/// Scheduling policy of the control thread.
enum class SchedulingPolicy : std::uint8_t {
  other,    ///< ordinary time sharing: no rights are requested
  fifo,     ///< SCHED_FIFO: before every thread of lower priority
  deadline  ///< SCHED_DEADLINE: a guaranteed time in each wake period, granted or refused by the kernel
};

[[nodiscard]] constexpr const char* to_string(SchedulingPolicy policy) noexcept {
  switch (policy) {
    case SchedulingPolicy::other:
      return "other";
    case SchedulingPolicy::fifo:
      return "fifo";
    case SchedulingPolicy::deadline:
      return "deadline";
  }
  return "";
}

/// SCHED_FIFO priority of the watchdog in hard real time, where it is granted [-].
inline constexpr int watchdog_priority = 99;

/// Wake-ups of the control thread and the rights that it requests.
struct RealtimeParameters {
  int wake_every_periods{
      40};               ///< control periods run at each wake-up; above 1 for an in-process plant only [-]
  bool required{false};  ///< refuse to start without the rights, instead of reporting it
  WaitParameters wait{};
  SchedulingPolicy policy{SchedulingPolicy::fifo};
  int priority{80};                           ///< SCHED_FIFO priority of the control thread, 1…98 [-]
  std::int64_t deadline_runtime_ns{100'000};  ///< SCHED_DEADLINE: processor time in each wake period [ns]
  int cpu{-1};                                ///< the CPU it is bound to, or -1 for any [-]
  bool lock_memory{true};       ///< keep all memory resident, so that no page fault stops the control thread
  bool stage_statistics{true};  ///< time stamps between the stages of each control period
  std::int64_t gap_limit_ns{10'000};  ///< two time stamps further apart are a gap [ns]

  /// Age of the last wake-up at which the watchdog turns the gates off and the status frames report WATCHDOG.
  /// The default is half of the 100 ms within which a vehicle must receive the fault, which leaves room for
  /// the cycle times and the bus. [ns]
  std::int64_t watchdog_ns{50'000'000};

  std::uint32_t overrun_limit{3};  ///< overruns in a row that are a fault [-]

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (wake_every_periods < 1) return "a wake-up must run at least one control period";
    // 99 is for the kernel's own threads and the watchdog.
    if (priority < 1 || priority > 98) return "the priority must be from 1 to 98";
    if (cpu < -1) return "the CPU must be a number from 0, or -1 for any";
    if (watchdog_ns <= 0) return "the watchdog needs a time above zero";
    if (wait.spin_margin_ns < 0) return "the margin of hybrid waiting must not be below zero";
    if (wait.tick_lead_ns < 0) return "the time from a deadline to the kernel's tick must not be below zero";
    if (overrun_limit == 0) return "at least one overrun makes a fault";
    if (gap_limit_ns <= 0) return "the limit of a gap must be above zero";
    if (policy != SchedulingPolicy::deadline) return nullptr;
    if (deadline_runtime_ns < 1'024) return "SCHED_DEADLINE needs a runtime of at least 1.024 us";
    if (wait.mode == WaitMode::spin) {
      return "wait = \"spin\" uses up the time that policy = \"deadline\" grants, and the kernel would stop "
             "the thread in every period; take \"fifo\" or another wait";
    }
    if (cpu >= 0) {
      return "policy = \"deadline\" and a cpu exclude each other: the kernel accepts such threads for all "
             "CPUs only; take \"fifo\", or give the program a cpuset of its own";
    }
    return nullptr;
  }

  /// Checks of the values that must fit into a wake period (wake_period_ns [ns]).
  [[nodiscard]] constexpr const char* validate(std::int64_t wake_period_ns) const noexcept {
    if (policy == SchedulingPolicy::deadline && deadline_runtime_ns > wake_period_ns) {
      return "deadline_runtime_us is too long: it must fit into the wake period";
    }
    if (wait.mode == WaitMode::hybrid && wait.spin_margin_ns >= wake_period_ns) {
      return "spin_margin_us is too long: wait = \"hybrid\" never sleeps unless it is shorter than the wake "
             "period; shorten it, or take \"spin\"";
    }
    return nullptr;
  }
};

inline void describe(Description& d, RealtimeParameters& p) {
  auto& [wake_every_periods, required, wait, policy, priority, deadline_runtime_ns, cpu, lock_memory,
         stage_statistics, gap_limit_ns, watchdog_ns, overrun_limit] = p;
  d.integer("wake_every_periods", wake_every_periods, "", 1, 10'000, "control periods run at each wake-up");
  d.flag("required", required, "refuse to start without the rights to real time");
  describe(d, wait);
  d.choice("policy", policy,
           {{"fifo", SchedulingPolicy::fifo},
            {"deadline", SchedulingPolicy::deadline},
            {"other", SchedulingPolicy::other}},
           "scheduling of the control thread");
  d.time("deadline_runtime_us", deadline_runtime_ns,
         in_us(1.024, 1e6, "SCHED_DEADLINE: processor time in each wake period"));
  d.integer("priority", priority, "", 1, 98, "SCHED_FIFO priority of the control thread");
  d.integer("cpu", cpu, "", -1, 1023, "CPU that the control thread is bound to, -1 for any");
  d.flag("lock_memory", lock_memory, "keep all memory resident");
  d.flag("stage_statistics", stage_statistics, "time the stages of each control period");
  d.time("gap_limit_us", gap_limit_ns,
         in_us(0.1, 1e6, "two time stamps of the control thread further apart are a gap"));
  d.time("watchdog_ms", watchdog_ns, in_ms(1, 1e5, "age of the last wake-up at which the gates turn off"));
  d.integer("overrun_limit", overrun_limit, "", 1, 1'000'000, "overruns in a row that make a fault");
}

}  // namespace sextant
