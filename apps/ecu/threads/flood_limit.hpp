#pragma once

#include <cstdint>

namespace sextant::ecu {

/// Limits the processor time of the receive thread during a flood of frames, which at a real-time priority
/// would keep all lower threads from running. After `most_in_a_row` frames that had arrived before `receive`
/// was called the thread pauses. A bus of 1 Mbit/s carries fewer than 40 frames in 1 ms, so that the backlog
/// of such a pause ends in time and no frame is lost.
class FloodLimit {
 public:
  static constexpr int most_in_a_row = 64;             ///< frames without waiting for one [-]
  static constexpr std::int64_t pause_ns = 1'000'000;  ///< [ns]

  /// `receive` was called at called_ns; its frame had arrived at arrived_ns, CLOCK_MONOTONIC [ns]. True: the
  /// thread must pause.
  [[nodiscard]] bool must_pause(std::int64_t called_ns, std::int64_t arrived_ns) noexcept {
    in_a_row_ = arrived_ns < called_ns ? in_a_row_ + 1 : 0;
    if (in_a_row_ < most_in_a_row) return false;
    in_a_row_ = 0;
    return true;
  }

 private:
  int in_a_row_{0};
};

}  // namespace sextant::ecu
