#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "control/reference_machine.hpp"
#include "sextant/control/direct_torque_controller.hpp"

namespace sextant::test {

/// A controller closed around the reference machine at imposed speed. What the controller believes of the
/// machine may differ from what it is. With an actuation delay in its parameters a pattern is applied one
/// period late.
template <class T, class C = DirectTorqueController<T>>
class ControlledMachine {
 public:
  using Parameters = typename C::Parameters;
  static constexpr std::int32_t period_ns = 25'000;

  explicit ControlledMachine(const Parameters& parameters,
                             const InductionMachineParameters<double>& real = {})
      : machine{real}, is_late_{parameters.actuation_delay_periods == 1}, controller_{parameters} {}

  /// One period; returns the machine's torque at its end. [N·m]
  double step(ControlMode mode, double torque) {
    const GatePattern decided =
        controller_.step(machine.template measure<T>(applied_), {mode, T(torque), T(flux_share)});
    const GatePattern pattern = is_late_ ? std::exchange(in_flight_, decided) : decided;
    if (is_driven(pattern.last_state())) {
      applied_ = pattern;
      machine.apply(applied_);
    } else {
      applied_ = GatePattern{gates_off, period_ns};
      machine.coast(period_ns);
    }
    peak_current = std::max(peak_current, std::abs(machine.i_s()));
    return machine.torque();
  }

  /// Torque within periods against its reference. [N·m]
  struct Ripple {
    double worst{0};
    double rms{0};
    double bias{0};
    double worst_flux{0};  ///< largest deviation of the stator flux from psi_ref [Wb]
  };

  /// For `ms` milliseconds, each pattern in parts of at most 1 µs.
  Ripple ripple(double torque, double ms, double psi_ref) {
    Ripple r;
    double squares = 0;
    double time = 0;
    machine.on_part = [&](double dt) {
      const double error = machine.torque() - torque;
      r.worst = std::max(r.worst, std::abs(error));
      r.worst_flux = std::max(r.worst_flux, std::abs(std::abs(machine.psi_s) - psi_ref));
      r.bias += error * dt;
      squares += error * error * dt;
      time += dt;
    };
    for (int k = 0; k < int(ms * 1e6 / period_ns); ++k) step(ControlMode::torque, torque);
    machine.on_part = {};
    r.bias /= time;
    r.rms = std::sqrt(squares / time);
    return r;
  }

  /// For `ms` milliseconds; returns the mean torque of the last quarter of it. [N·m]
  double run(ControlMode mode, double torque, double ms) {
    const int periods = int(ms * 1e6 / period_ns);
    const int counted = std::max(1, periods / 4);
    double sum = 0;
    for (int k = 0; k < periods; ++k) {
      const double now = step(mode, torque);
      if (k >= periods - counted) sum += now / counted;
    }
    return sum;
  }

  /// Magnetises; returns the time it takes, or -1 where it does not end within a second. [ms]
  double magnetise() {
    const int most = 1'000'000'000 / period_ns;
    for (int k = 0; k < most; ++k) {
      if (k > 0 && controller_.estimate().magnetised) return k * period_ns * 1e-6;
      step(ControlMode::magnetise, 0);
    }
    return -1;
  }

  [[nodiscard]] const ControlEstimate<T>& estimate() const { return controller_.estimate(); }
  [[nodiscard]] const GatePattern& applied() const { return applied_; }

  ReferenceMachine machine;
  double flux_share{1};    ///< of the references [-]
  double peak_current{0};  ///< since the test has set it to zero [A]

 private:
  bool is_late_;
  C controller_;
  GatePattern in_flight_{gates_off, period_ns};
  GatePattern applied_{gates_off, period_ns};
};

}  // namespace sextant::test
