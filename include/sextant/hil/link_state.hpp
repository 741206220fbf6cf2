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
    stale_.store(assembler.stale(), std::memory_order_relaxed);
    unheard_.store(assembler.unheard(), std::memory_order_relaxed);
    refusals_.store(assembler.counters().refused, std::memory_order_relaxed);
  }

  /// True while there is no plant, or it is silent.
  [[nodiscard]] bool stale() const noexcept { return stale_.load(std::memory_order_relaxed); }
  /// True while the plant answers, but takes nothing of what the drive writes.
  [[nodiscard]] bool unheard() const noexcept { return unheard_.load(std::memory_order_relaxed); }
  /// Patterns against which the plant has opened its gates. [-]
  [[nodiscard]] std::uint64_t refusals() const noexcept { return refusals_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> stale_{true};
  std::atomic<bool> unheard_{false};
  std::atomic<std::uint64_t> refusals_{0};
};

}  // namespace sextant
