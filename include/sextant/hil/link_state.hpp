#pragma once

#include <atomic>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/measurement_assembler.hpp"

namespace sextant {

/// What a drive knows of its plant, published by its control thread once a period for any other.
class LinkState {
 public:
  void publish(const MeasurementAssembler& assembler) noexcept SEXTANT_NONBLOCKING {
    timed_out_.store(assembler.timed_out(), std::memory_order_relaxed);
    unacknowledged_.store(assembler.unacknowledged(), std::memory_order_relaxed);
    refusals_.store(assembler.counters().refused, std::memory_order_relaxed);
  }

  /// True while there is no plant, or it has timed out.
  [[nodiscard]] bool timed_out() const noexcept { return timed_out_.load(std::memory_order_relaxed); }
  /// True while the plant answers, but acknowledges no pattern of the drive.
  [[nodiscard]] bool unacknowledged() const noexcept {
    return unacknowledged_.load(std::memory_order_relaxed);
  }
  /// Patterns against which the plant has opened its gates. [-]
  [[nodiscard]] std::uint64_t refusals() const noexcept { return refusals_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> timed_out_{true};
  std::atomic<bool> unacknowledged_{false};
  std::atomic<std::uint64_t> refusals_{0};
};

}  // namespace sextant
