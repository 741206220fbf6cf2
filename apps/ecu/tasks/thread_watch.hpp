#pragma once

#include <cstdint>

namespace sextant::ecu {

/// Tells from another thread's count of polls whether that thread has stopped. It counts its own steps and
/// reads no clock, so that a stop of the whole process is none of the other thread.
///
/// A thread is watched by one that runs without it: the watchdog and the telemetry thread by the housekeeping
/// thread, that one by the telemetry thread.
class ThreadWatch {
 public:
  enum class Change : std::uint8_t { none, stopped, resumed };

  static constexpr int timeout_ms = 800;  ///< own time without a poll that makes a stop [ms]

  /// step_ms: time between two steps; the timeout is above that between two polls [ms].
  explicit constexpr ThreadWatch(int step_ms) noexcept : timeout_steps_{timeout_ms / step_ms} {}

  /// polls: of the other thread so far, 0 before it has started [-].
  constexpr Change step(std::uint64_t polls) noexcept {
    const bool was_stopped = steps_ == timeout_steps_;
    if (polls != polls_ || polls == 0) {
      polls_ = polls;
      steps_ = 0;
      return was_stopped ? Change::resumed : Change::none;
    }
    if (was_stopped) return Change::none;
    return ++steps_ == timeout_steps_ ? Change::stopped : Change::none;
  }

 private:
  int timeout_steps_;
  std::uint64_t polls_{0};
  int steps_{0};  ///< without a poll of the other thread [-]
};

}  // namespace sextant::ecu
