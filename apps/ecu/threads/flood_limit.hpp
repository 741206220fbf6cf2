#pragma once

#include <cstdint>

namespace sextant::ecu {

/// Keeps a flood of frames from occupying the receive thread without end, which with a real-time priority
/// would take its processor from everything below. So many frames in a row that had arrived before they were
/// asked for, and the thread is to pause. A bus of 1 Mbit/s carries fewer than 40 frames in 1 ms, so that
/// after a pause of that length its backlog ends in time and nothing is lost.
class FloodLimit {
 public:
  static constexpr int most_in_a_row = 64;             ///< frames without waiting for one [-]
  static constexpr std::int64_t pause_ns = 1'000'000;  ///< [ns]

  /// A frame was asked for at asked_ns and had arrived at arrived_ns, CLOCK_MONOTONIC [ns]. True
  /// where the thread is to pause.
  [[nodiscard]] bool must_pause(std::int64_t asked_ns, std::int64_t arrived_ns) noexcept {
    in_a_row_ = arrived_ns < asked_ns ? in_a_row_ + 1 : 0;
    if (in_a_row_ < most_in_a_row) return false;
    in_a_row_ = 0;
    return true;
  }

 private:
  int in_a_row_{0};
};

}  // namespace sextant::ecu
