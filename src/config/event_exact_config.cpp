#include "sextant/config/scenario_config.hpp"

namespace sextant {

void describe(Section s, EventExactParameters& p) {
  constexpr double ns_per_us = 1e3;
  s.integer("minimum_dwell_ns", p.minimum_dwell_ns, {0, 1'000'000}, "ns",
            "shortest time between two switching instants; sooner events wait and are counted");
  s.number("initial_flux_wb", p.initial_flux, {0, 10}, "Wb",
           "stator flux of the machine at the beginning, along phase a; 0: no flux");
  s.number("sector_mask_wb", p.sector_mask, {1e-9, 1}, "Wb", "flux below which the sector is held");
  s.time("max_step_us", p.max_step_ns, ns_per_us, {0.01, 1e3}, "us",
         "longest step of integrator \"fixed\", longest piece between two evaluations of the run");
  s.integer("max_events", p.max_events, {1, 1'000'000'000}, "1/s",
            "events in a second at which a run is ended");
  s.check(p);
}

EventExactRunner::Parameters ScenarioConfig::event_exact_runner() const {
  return {.plant = drive.plant.plant,
          .control = drive.direct_torque(),
          .protection = drive.drive.protection,
          .event_exact = event_exact,
          .integrator = drive.plant.integrator,
          .cvode = drive.plant.cvode,
          .u_dc = drive.plant.io.u_dc};
}

}  // namespace sextant
