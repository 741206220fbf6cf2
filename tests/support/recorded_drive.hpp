#pragma once

#include <cstdint>
#include <utility>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant::testing {

/// A drive on a simulated machine of fixed step, period by period, that shows what passes between them.
template <class C = DirectTorqueController<double>>
class RecordedDrive {
 public:
  static constexpr std::int64_t period_ns = 25'000;

  RecordedDrive(const MechanicalLoad::Parameters& load, const ProfileParameters& torque)
      : stage_{power_stage(), load}, io_{stage_.io()}, commands_{torque} {}
  RecordedDrive(const RecordedDrive&) = delete;
  RecordedDrive& operator=(const RecordedDrive&) = delete;

  /// Calls show(k, measurement, pattern) after each control period k ≥ 0.
  template <class Show>
  void run(std::int64_t periods, Show&& show) {
    for (std::int64_t k = -ScenarioCommands::hand_shake_periods; k < periods; ++k) {
      run_cycle(k * period_ns, io_, commands_, drive_, sink_);
      if (k >= 0) show(k, std::as_const(io_.last), std::as_const(io_.written));
    }
  }

  [[nodiscard]] const DrivePlant<double>& plant() { return stage_.io().plant(); }

 private:
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

  static SimulatedPowerStage::Parameters power_stage() {
    SimulatedPowerStage::Parameters parameters;
    parameters.integrator = IntegratorKind::fixed;
    return parameters;
  }

  SimulatedPowerStage stage_;
  Tap io_;
  C controller_{typename C::Parameters{}};
  Drive<double> drive_{{}, controller_};
  ScenarioCommands commands_;
  Sink sink_{};
};

}  // namespace sextant::testing
