#pragma once

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/event_exact/event_exact_parameters.hpp"
#include "sextant/plant/cvode_parameters.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario.hpp"
#include "sextant/safety/protection.hpp"

namespace sextant {

/// Runs a scenario event-exactly: comparators and estimator in continuous time beside the plant, switching at
/// the instants of their thresholds, as the paper's variable-step model does. There are no drive states: the
/// torque reference acts from time zero on. A protection that trips ends the run.
class EventExactRunner {
 public:
  struct Parameters {
    DrivePlantParameters<> plant{};
    DirectTorqueController<>::Parameters control{};
    Protection<>::Parameters protection{};
    EventExactParameters event_exact{};
    IntegratorKind integrator{IntegratorKind::cvode};  ///< CVODE, or Runge-Kutta with a fixed longest step
    CvodeParameters cvode{};
    double u_dc{530.0};  ///< stiff DC-link voltage [V]
  };

  explicit EventExactRunner(const Parameters& parameters) : parameters_{parameters} {}

  /// Runs the whole scenario. `trace` may be null. Throws what the scenario's parts throw on bad parameters.
  [[nodiscard]] MilResult run(const Scenario& scenario, TraceRecorder* trace,
                              const MilRunner::Progress& progress);

 private:
  Parameters parameters_;
};

}  // namespace sextant
