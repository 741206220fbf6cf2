#pragma once

#include <cstdint>

#include "control/reference_machine.hpp"
#include "sextant/control/direct_torque_controller.hpp"

namespace sextant::test {

/// A direct torque controller closed around the reference machine, whose inverter may act one period late.
template <class T>
class Loop {
 public:
  explicit Loop(const typename DirectTorqueController<T>::Parameters& parameters = {}, int plant_delay = 0)
      : period_ns{parameters.period_ns}, controller_{parameters}, plant_delay_{plant_delay} {}

  void step(ControlMode mode, double torque, double flux_share = 1) {
    const GatePattern decided =
        controller_.step(machine.measure<T>(applied_), {mode, T(torque), T(flux_share)});
    applied_ = plant_delay_ > 0 ? waiting_ : decided;
    waiting_ = decided;
    last_ = decided;
    if (is_driven(applied_.last_state())) {
      machine.apply(applied_);
    } else {
      applied_ = GatePattern{gates_off, period_ns};
      machine.coast(period_ns);
    }
  }

  [[nodiscard]] DirectTorqueController<T>& controller() { return controller_; }
  [[nodiscard]] const GatePattern& last() const { return last_; }
  [[nodiscard]] const GatePattern& applied() const { return applied_; }  ///< in the last step

  std::int32_t period_ns;
  ReferenceMachine machine{InductionMachineParameters<double>{}};

 private:
  DirectTorqueController<T> controller_;
  int plant_delay_;
  GatePattern applied_{};
  GatePattern waiting_{};
  GatePattern last_{};
};

}  // namespace sextant::test
