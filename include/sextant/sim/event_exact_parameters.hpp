#pragma once

#include <cmath>
#include <cstdint>

namespace sextant {

/// What an event-exact run needs beyond drive and plant.
struct EventExactParameters {
  std::int64_t minimum_dwell_ns{100};  ///< a switching state lasts at least as long; 0: no limit [ns]
  double initial_flux{0};              ///< machine pre-magnetised along phase a with this stator flux [Wb]
  double sector_mask{1e-3};          ///< flux below which the sector is held; at ψ = 0 every edge is met [Wb]
  std::int64_t max_step_ns{20'000};  ///< longest step of the fixed-step engine, longest piece of a trace [ns]
  std::int64_t max_events{100'000'000};  ///< events in one simulated second, at most [-]

  [[nodiscard]] const char* validate() const noexcept {
    if (minimum_dwell_ns < 0) return "the minimum dwell must not be below zero";
    if (!(std::isfinite(initial_flux) && initial_flux >= 0)) return "the initial flux must not be below zero";
    if (!(std::isfinite(sector_mask) && sector_mask > 0)) return "the sector mask must be above zero";
    if (max_step_ns < 1) return "the longest step must be at least 1 ns";
    return max_events >= 1 ? nullptr : "the events in a second must be at least one";
  }
};

}  // namespace sextant
