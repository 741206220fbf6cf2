// The header-only core alone: one step of direct torque control.
#include <cstdio>

#include "sextant/control/direct_torque_controller.hpp"

int main() {
  sextant::DirectTorqueController<float> controller{{}};
  sextant::Measurement<float> measurement;
  measurement.u_dc = 530.0F;
  const sextant::GatePattern pattern = controller.step(measurement, {sextant::ControlMode::torque, 15.0F});
  const bool driven = sextant::is_driven(pattern.last_state());
  std::printf("first pattern is %s\n", driven ? "driven" : "off");
  return driven ? 0 : 1;
}
