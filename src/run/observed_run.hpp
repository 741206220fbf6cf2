#pragma once

#include <algorithm>
#include <cstdint>

#include "sampled_observer.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {

/// A sampled run of a scenario on one power stage, from its control periods to its result; who runs the
/// drive is the caller's.
template <class Io>
class ObservedRun {
 public:
  /// Nothing is owned; controller and trace may be null.
  ObservedRun(const Scenario& scenario, std::int64_t period_ns, Io& io, const Controller<>* controller,
              TraceRecorder* trace)
      : commands_{scenario}, observer_{scenario, period_ns, io, controller, trace}, io_{io} {}

  /// What the scenario commands.
  [[nodiscard]] ScenarioCommands& commands() noexcept { return commands_; }

  /// A control period that has run, on the scenario's time. False where the plant has failed: a state that no
  /// machine can have is not recorded.
  bool period(const Telemetry<double>& now) {
    result_.note_faults(now.latched, now.first_fault, now.t_ns);
    // A driver sees the speed of the vehicle: by that of a motor before a soft shaft the loop is unstable.
    commands_.note_speed(io_.load_speed(now.omega_m));
    commands_.note_regenerating(now.torque_regenerating);
    io_.set_brake(commands_.brake_torque());
    if (!io_.healthy()) return false;
    observer_.period(now, commands_);
    simulated_ns_ = std::max(simulated_ns_, now.t_ns);
    result_.final_state = now.state;
    return true;
  }

  /// Of the run so far, which took that time [s].
  [[nodiscard]] MilResult result(double wall_s) const {
    MilResult result = result_;
    result.metrics = observer_.metrics().metrics();
    result.metrics[Metric::simulated] = double(simulated_ns_) * 1e-9;
    result.metrics[Metric::wall] = wall_s;
    result.metrics[Metric::realtime_factor] = result.metrics[Metric::simulated] / wall_s;
    if (const auto count = io_.short_pulses()) result.metrics[Metric::short_pulses] = double(*count);
    if (const auto energy = io_.brake_energy()) result.metrics[Metric::energy_brake] = *energy;
    result.window_metrics = observer_.metrics().window_metrics(result.metrics);
    result.missing_torque = observer_.metrics().missing_torque();
    result.cycle_departure = observer_.metrics().cycle_departure();
    result.plant_healthy = io_.healthy();
    result.plant_reachable = io_.plant().is_reachable();
    return result;
  }

 private:
  ScenarioCommands commands_;
  SampledObserver<Io> observer_;
  Io& io_;
  std::int64_t simulated_ns_{0};
  MilResult result_{};
};

}  // namespace sextant
