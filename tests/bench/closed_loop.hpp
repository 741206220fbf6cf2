#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "sextant/config/make_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant::bench {

/// A drive and its plant over one scenario: its gate patterns, the plant's torque under given patterns, and
/// the whole run with its metrics.
class ClosedLoop {
 public:
  using Patterns = std::vector<GatePattern>;
  using Torque = std::vector<double>;  ///< of the plant, at the end of each control period [N·m]

  ClosedLoop(const DriveConfig& config, const Scenario& scenario) : config_{config}, scenario_{scenario} {}

  /// The patterns that the drive decides, from the beginning of its hand-shake on. Throws std::runtime_error
  /// where it does not produce torque at the end.
  [[nodiscard]] Patterns record() const {
    MeteredPowerStage stage{config_.plant, scenario_.load};
    const std::unique_ptr<Controller<double>> controller = make_controller(config_);
    Drive<double> drive{config_.drive, *controller};
    ScenarioCommands commands{scenario_};
    Patterns patterns;
    for (std::int64_t t_ns = begin_ns(); t_ns < scenario_.duration_ns; t_ns += period_ns()) {
      const Measurement<double> measurement = stage.io().read(t_ns);
      patterns.push_back(drive.step(t_ns, measurement, commands.latest(t_ns)).pattern);
      stage.io().write(patterns.back());
    }
    const bool makes_torque = drive.state() == DriveState::torque || drive.state() == DriveState::derated;
    if (!makes_torque || !stage.io().healthy())
      throw std::runtime_error{"the recorded drive does not produce torque"};
    return patterns;
  }

  /// The plant under these patterns, without the drive. Throws std::runtime_error where the integration
  /// fails.
  [[nodiscard]] Torque replay(const Patterns& patterns,
                              const SimulatedPowerStageParameters& parameters) const {
    MeteredPowerStage stage{parameters, scenario_.load};
    Torque torque;
    torque.reserve(patterns.size());
    std::int64_t t_ns = begin_ns();
    (void)stage.io().read(t_ns);
    for (const GatePattern& pattern : patterns) {
      stage.io().write(pattern);
      (void)stage.io().read(t_ns += period_ns());
      torque.push_back(stage.io().plant().tau_e());
    }
    if (!stage.io().healthy()) throw std::runtime_error{"an integration failed"};
    return torque;
  }

  /// The scenario as sextant-mil runs it, with its metrics and without a trace.
  [[nodiscard]] MilResult run(IntegratorKind integrator) const {
    SimulatedPowerStageParameters parameters = config_.plant;
    parameters.integrator = integrator;
    MeteredPowerStage stage{parameters, scenario_.load};
    const std::unique_ptr<Controller<double>> controller = make_controller(config_);
    Drive<double> drive{config_.drive, *controller};
    return MilRunner{drive, stage.io(), config_.drive.period_ns, controller.get()}.run(scenario_, nullptr,
                                                                                       {});
  }

 private:
  [[nodiscard]] std::int64_t period_ns() const noexcept { return config_.drive.period_ns; }
  [[nodiscard]] std::int64_t begin_ns() const noexcept {
    return -ScenarioCommands::hand_shake_periods * period_ns();
  }

  DriveConfig config_;
  Scenario scenario_;
};

}  // namespace sextant::bench
