#pragma once

#include <cstdint>
#include <vector>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/sim/scenario_commands.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::testing {

inline constexpr std::int64_t recorded_period_ns = 25'000;

/// The gate patterns of a drive as it magnetises a machine at rest, accelerates it with 20 N·m, brakes it
/// with −20 N·m and accelerates it again, a switching state for each period of 25 µs: one sequence that every
/// integrator can be given. The load torque is 2 N·m.
inline std::vector<SwitchState> record_switching(double duration_s) {
  struct Sink {
    void push(const Telemetry<double>&) noexcept SEXTANT_NONBLOCKING {}
  };
  struct Tap final : DriveIo<double> {
    explicit Tap(DriveIo<double>& io) : inner{io} {}
    Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
      return inner.read(t_ns);
    }
    void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
      inner.write(pattern);
      written = pattern;
    }
    DriveIo<double>& inner;
    GatePattern written{};
  };

  SimulatedPowerStage::Parameters parameters;
  parameters.integrator = IntegratorKind::fixed;
  MechanicalLoad::Parameters load;
  load.load_torque = ProfileParameters{.value = 2.0};
  SimulatedPowerStage stage{parameters, load};
  Tap io{stage.io()};
  DirectTorqueController<double> controller{{}};
  Drive<double> drive{{}, controller};
  ScenarioCommands commands{
      ProfileParameters{.shape = ProfileShape::steps,
                        .points = {{0.0, 20.0}, {0.45 * duration_s, -20.0}, {0.7 * duration_s, 20.0}}}};
  Sink sink;
  std::vector<SwitchState> sequence;
  const auto periods = std::int64_t(duration_s * 1e9) / recorded_period_ns;
  for (std::int64_t k = -ScenarioCommands::hand_shake_periods; k < periods; ++k) {
    run_cycle(k * recorded_period_ns, io, commands, drive, sink);
    if (k >= 0) sequence.push_back(io.written.last_state());
  }
  return sequence;
}

}  // namespace sextant::testing
