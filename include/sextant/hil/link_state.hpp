#pragma once

#include <atomic>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/measurement_assembler.hpp"

namespace sextant {

/// State of a drive's plant: written by the control thread once a period, read by any thread.
class LinkState {
 public:
  void publish(const MeasurementAssembler& assembler) noexcept SEXTANT_NONBLOCKING {
    timed_out_.store(assembler.timed_out(), std::memory_order_relaxed);
    unacknowledged_.store(assembler.unacknowledged(), std::memory_order_relaxed);
    refusals_.store(assembler.counters().refused, std::memory_order_relaxed);
  }

  /// True while there is no plant, or it has timed out.
  [[nodiscard]] bool timed_out() const noexcept { return timed_out_.load(std::memory_order_relaxed); }
  /// True while the plant sends measurements and acknowledges no pattern of the drive.
  [[nodiscard]] bool unacknowledged() const noexcept {
    return unacknowledged_.load(std::memory_order_relaxed);
  }
  /// Driven patterns against which the plant's gates were off. [-]
  [[nodiscard]] std::uint64_t refusals() const noexcept { return refusals_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> timed_out_{true};
  std::atomic<bool> unacknowledged_{false};
  std::atomic<std::uint64_t> refusals_{0};
};

}  // namespace sextant
