#pragma once

#include <bit>
#include <cstdint>

#include "sextant/core/fault.hpp"

namespace sextant {

/// Keeps the faults since the last reset, the first of them, and their number since start. Of faults in one
/// period the one with the lowest bit counts as first.
class FaultMemory {
 public:
  constexpr void step(FaultSet active) noexcept {
    active_ = active;
    const std::uint64_t fresh = active.bits() & ~latched_.bits();
    if (fresh == 0) return;
    if (!latched_.any()) first_ = static_cast<Fault>(std::countr_zero(fresh));
    latched_ |= active;
    total_ += static_cast<std::uint32_t>(std::popcount(fresh));
  }

  /// Clears the latched faults; the total since start stays.
  constexpr void reset() noexcept { latched_ = {}; }

  [[nodiscard]] constexpr FaultSet active() const noexcept { return active_; }
  [[nodiscard]] constexpr FaultSet latched() const noexcept { return latched_; }
  [[nodiscard]] constexpr Fault first() const noexcept { return first_; }  ///< meaningful while latched
  [[nodiscard]] constexpr std::uint32_t total() const noexcept { return total_; }

 private:
  FaultSet active_{};
  FaultSet latched_{};
  std::uint32_t total_{0};
  Fault first_{};
};

}  // namespace sextant
