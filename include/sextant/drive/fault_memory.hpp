#pragma once

#include <cstdint>

#include "sextant/core/fault.hpp"

namespace sextant {

/// Remembers which faults have tripped since the last reset, which was first, and how many there were.
class FaultMemory {
 public:
  constexpr void step(FaultSet active) noexcept {
    active_ = active;
    for (int i = 0; active.any() && i < fault_count; ++i) {
      const auto fault = static_cast<Fault>(i);
      if (!active.test(fault) || latched_.test(fault)) continue;
      if (!latched_.any()) first_ = fault;
      latched_.set(fault);
      ++total_;
    }
  }

  /// Forgets what is latched; the total since start stays.
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
