#pragma once

#include <cstdint>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant::bench {

/// A whole drive with its plant: 15 N·m at an imposed 50 rad/s, 25 µs.
class BenchDrive {
 public:
  static constexpr std::int64_t period_ns = 25'000;

  explicit BenchDrive(IntegratorKind integrator = IntegratorKind::fixed)
      : stage_{plant_with(integrator), load()}, commands_{ProfileParameters{.value = 15.0}} {}
  BenchDrive(const BenchDrive&) = delete;
  BenchDrive& operator=(const BenchDrive&) = delete;

  /// One control period. TelemetrySink as in `run_cycle`.
  template <class TelemetrySink>
  void run_period(TelemetrySink& telemetry) noexcept {
    run_cycle(t_ns_, stage_.io(), commands_, drive_, telemetry);
    t_ns_ += period_ns;
  }

  /// Whether the drive makes torque and the plant could be integrated so far.
  [[nodiscard]] bool healthy() noexcept {
    return stage_.io().healthy() && drive_.state() == DriveState::torque;
  }

 private:
  static SimulatedPowerStage::Parameters plant_with(IntegratorKind integrator) {
    SimulatedPowerStage::Parameters parameters;
    parameters.integrator = integrator;
    return parameters;
  }
  static MechanicalLoad::Parameters load() {
    MechanicalLoad::Parameters load;
    load.imposed_speed = ProfileParameters{.value = 50.0};
    return load;
  }

  SimulatedPowerStage stage_;
  DirectTorqueController<double> controller_{{}};
  Drive<double> drive_{{}, controller_};
  ScenarioCommands commands_;
  std::int64_t t_ns_{-ScenarioCommands::hand_shake_periods * period_ns};
};

}  // namespace sextant::bench
