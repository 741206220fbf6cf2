#pragma once

#include <vector>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/sim/scenario_commands.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::bench {

/// Measurements and patterns of a settled drive at 15 N·m and 50 rad/s, one control period each: the inputs
/// that every contestant gets.
struct RecordedRun {
  std::vector<Measurement<double>> measurements{};
  std::vector<GatePattern> patterns{};  ///< decided on the measurement of the same index
};

/// Few enough to stay in the first-level cache, as a live drive's single measurement does.
inline constexpr int recorded_periods = 192;

inline constexpr double torque_reference = 15.0;  // [N·m]

inline RecordedRun record_run() {
  struct Sink {
    void push(const Telemetry<double>&) noexcept SEXTANT_NONBLOCKING {}
  };
  struct Tap final : DriveIo<double> {
    explicit Tap(DriveIo<double>& io) : inner{io} {}
    Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
      return last = inner.read(t_ns);
    }
    void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
      inner.write(pattern);
      written = pattern;
    }
    DriveIo<double>& inner;
    Measurement<double> last{};
    GatePattern written{};
  };

  SimulatedPowerStage::Parameters parameters;
  parameters.integrator = IntegratorKind::fixed;
  MechanicalLoad::Parameters load;
  load.imposed_speed = ProfileParameters{.value = 50.0};
  SimulatedPowerStage stage{parameters, load};
  Tap io{stage.io()};
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{}, controller};
  ScenarioCommands commands{ProfileParameters{.value = torque_reference}};
  Sink sink;
  RecordedRun run;
  constexpr std::int64_t period_ns = 25'000;
  for (std::int64_t k = -ScenarioCommands::hand_shake_periods; k < 8'000 + recorded_periods; ++k) {
    run_cycle(k * period_ns, io, commands, drive, sink);
    if (k < 8'000) continue;
    run.measurements.push_back(io.last);
    run.patterns.push_back(io.written);
  }
  return run;
}

}  // namespace sextant::bench
