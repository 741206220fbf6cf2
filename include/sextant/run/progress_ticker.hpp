#pragma once

#include <chrono>
#include <cstdint>

#include "sextant/run/mil_runner.hpp"

namespace sextant {

/// Reports the progress of a run, some twenty times a second of wall time.
class ProgressTicker {
 public:
  /// `calls`: a power of two; the clock is read once in as many ticks.
  ProgressTicker(const MilRunner::Progress& progress, std::uint32_t calls)
      : progress_{progress}, mask_{calls - 1U} {}

  /// False when the run shall stop.
  bool tick(double fraction) {
    if (!progress_ || (++calls_ & mask_) != 0) return true;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds{50}) return true;
    last_ = now;
    return progress_(fraction);
  }

 private:
  const MilRunner::Progress& progress_;
  std::uint32_t mask_;
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
  std::uint32_t calls_{0};
};

}  // namespace sextant
