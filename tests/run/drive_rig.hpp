#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {

/// Everything a drive with its plant is made of; control period and delay are said once. The drive is the
/// paper's: open voltage model, torque at once.
struct RigParameters {
  SimulatedPowerStage::Parameters stage{.integrator = IntegratorKind::fixed};
  MechanicalLoad::Parameters load{};
  DirectTorqueController<>::Parameters controller{{.flux_estimator = FluxEstimatorKind::voltage_model}};
  Drive<>::Parameters drive{.magnetise_first = false};

  static RigParameters at_speed(double omega_m, IntegratorKind integrator = IntegratorKind::fixed) {
    RigParameters p;
    p.stage.integrator = integrator;
    p.load.imposed_speed = ProfileParameters{.value = omega_m};
    return p;
  }
  RigParameters& with_actuation_delay() {
    stage.io.actuation_delay_periods = 1;
    controller.actuation_delay_periods = 1;
    return *this;
  }
};

/// What was seen over a stretch of time, at every control period.
struct Stretch {
  double mean_torque{};                     ///< [N·m]
  double peak_current{};                    ///< largest |i_s| [A]
  std::optional<double> reached_after_s{};  ///< from the beginning, first at 95 % of the step [s]
};

/// A drive on its simulated power stage, commanded by hand on virtual time.
template <class ControlMethod = DirectTorqueController<double>>
class DriveRigOf {
 public:
  static constexpr std::int64_t period_ns = 25'000;
  static constexpr double period_s = 25e-6;

  explicit DriveRigOf(const RigParameters& p = {}) : DriveRigOf{p, p.controller} {}
  /// With parameters of the control method that stand in the place of `p.controller`.
  DriveRigOf(const RigParameters& p, const typename ControlMethod::Parameters& controller)
      : stage_{p.stage, p.load}, controller_{controller}, drive_{p.drive, controller_} {}

  /// The hand-shake of the contract; the next period is the first with torque.
  void start() {
    enable = false;
    run_periods(3);
    enable = true;
    run_periods(1);
  }

  void step() {
    run_cycle(t_ns, io(), *this, drive_, *this);
    t_ns += period_ns;
  }
  void run_periods(std::int64_t n) {
    for (std::int64_t k = 0; k < n; ++k) step();
  }
  void run(double seconds) { run_periods(std::llround(seconds / period_s)); }

  /// Runs and watches the plant; `from` is the torque before a step to the present reference.
  Stretch watch(double seconds, double from = 0.0) {
    Stretch seen;
    const std::int64_t n = std::llround(seconds / period_s);
    const double way = torque - from;
    for (std::int64_t k = 0; k < n; ++k) {
      step();
      seen.mean_torque += plant().tau_e() / double(n);
      seen.peak_current = std::max(seen.peak_current, magnitude(plant().i_s()));
      const bool reached =
          way > 0.0 ? plant().tau_e() >= from + 0.95 * way : plant().tau_e() <= from + 0.95 * way;
      if (reached && way != 0.0 && !seen.reached_after_s) seen.reached_after_s = double(k) * period_s;
    }
    return seen;
  }

  // The commands and the telemetry of run_cycle.
  DriveRequest<double> latest(std::int64_t now_ns) noexcept {
    DriveRequest<double> request;
    request.command = {.torque = torque,
                       .torque_limit = 1e3,
                       .enable = enable,
                       .fault_reset = fault_reset,
                       .received_ns = now_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    return request;
  }
  void push(const Telemetry<double>& t) noexcept { telemetry = t; }

  [[nodiscard]] SimulatedDriveIo<>& io() noexcept { return stage_.io(); }
  [[nodiscard]] const DrivePlant<double>& plant() noexcept { return io().plant(); }
  [[nodiscard]] Drive<double>& drive() noexcept { return drive_; }

  double torque{0.0};  ///< request [N·m]
  bool enable{false};
  bool fault_reset{false};
  std::int64_t t_ns{0};  ///< beginning of the next period [ns]
  Telemetry<double> telemetry{};

 private:
  SimulatedPowerStage stage_;
  ControlMethod controller_;
  Drive<double> drive_;
  std::uint64_t sequence_{0};
};
using DriveRig = DriveRigOf<>;

}  // namespace sextant
