#pragma once

#include <cstdint>

namespace sextant::ecu {

/// Tells from another thread's count of polls whether that thread has stopped. It counts its own steps and
/// reads no clock, so that a stop of the whole process is none of the other thread.
class TelemetryWatch {
 public:
  enum class Change : std::uint8_t { none, stopped, resumed };

  static constexpr int timeout_steps = 80;  ///< steps without a poll that make a stop [-]

  /// polls: of the other thread so far, 0 before it has started [-].
  constexpr Change step(std::uint64_t polls) noexcept {
    const bool was_stopped = left_ == 0;
    if (polls != polls_ || polls == 0) {
      polls_ = polls;
      left_ = timeout_steps;
      return was_stopped ? Change::resumed : Change::none;
    }
    if (was_stopped) return Change::none;
    return --left_ == 0 ? Change::stopped : Change::none;
  }

 private:
  std::uint64_t polls_{0};
  int left_{timeout_steps};  ///< until the other thread counts as stopped [-]
};

}  // namespace sextant::ecu
