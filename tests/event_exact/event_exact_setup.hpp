#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "sextant/event_exact/event_exact_runner.hpp"

namespace sextant {

/// The paper's machine on an imposed speed, with a constant torque reference, judged once it has settled.
struct EventExactSetup {
  EventExactRunner::Parameters parameters{};
  Scenario scenario{};

  static EventExactSetup at(double torque, double omega_m, double duration_s = 0.4) {
    EventExactSetup s;
    s.parameters.control.machine = s.parameters.plant.machine;
    s.parameters.protection.over_current = 400;
    s.parameters.integrator = IntegratorKind::fixed;
    s.scenario.duration_ns = static_cast<std::int64_t>(duration_s * 1e9);
    s.scenario.torque_reference.value = torque;
    s.scenario.load.imposed_speed = ProfileParameters{.value = omega_m};
    s.scenario.metrics.from_ns = s.scenario.duration_ns / 2;
    s.scenario.metrics.step_ns = 0;
    return s;
  }
  EventExactSetup& with_bands(double band) {
    parameters.control.torque_comparator.upper_band = band;
    parameters.control.torque_comparator.lower_band = band;
    return *this;
  }
  EventExactSetup& with_cvode(double relative_tolerance) {
    parameters.integrator = IntegratorKind::cvode;
    parameters.cvode.relative_tolerance = relative_tolerance;
    parameters.cvode.flux_tolerance = 1e-2 * relative_tolerance;
    return *this;
  }
  [[nodiscard]] MilResult run(TraceRecorder* trace = nullptr) const {
    return EventExactRunner{parameters}.run(scenario, trace, {});
  }
};

}  // namespace sextant
