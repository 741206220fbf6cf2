#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/description.hpp"

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

inline void describe(Description& d, EventExactParameters& p) {
  auto& [minimum_dwell_ns, initial_flux, sector_mask, max_step_ns, max_events] = p;
  d.integer("minimum_dwell_ns", minimum_dwell_ns, "ns", 0, 1'000'000,
            "shortest time between two switching instants; sooner events wait and are counted");
  d.number("initial_flux_wb", initial_flux,
           {"Wb", 0, 10, "stator flux of the machine at the beginning, along phase a; 0: no flux"});
  d.number("sector_mask_wb", sector_mask, {"Wb", 1e-9, 1, "flux below which the sector is held"});
  d.time("max_step_us", max_step_ns,
         in_us(0.01, 1e3,
               "longest step of integrator \"fixed\", longest piece between two evaluations of the run"));
  d.integer("max_events", max_events, "1/s", 1, 1'000'000'000, "events in a second at which a run is ended");
}

}  // namespace sextant
