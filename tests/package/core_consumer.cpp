// The header-only core alone: a drive by its setup, and one step of its direct torque control.
#include <cstdio>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/resolved.hpp"

int main() {
  using Controller = sextant::DirectTorqueController<float>;
  sextant::DriveSetup<float> setup;  // of the paper's machine
  setup.basis.period_ns = 50'000;
  setup.basis.u_dc = 400.0F;
  setup.basis.flux_reference = 0.9F;
  const sextant::ResolvedDrive<float> resolved = sextant::resolved(setup);
  Controller controller{sextant::default_parameters<Controller>(resolved.control)};
  const sextant::Drive<float> drive{resolved.drive, controller};
  if (setup.validate() != nullptr || resolved.validate() != nullptr) return 1;
  if (resolved.drive.validate(controller) != nullptr || drive.state() != sextant::DriveState::init) return 1;
  sextant::Measurement<float> measurement;
  measurement.u_dc = setup.basis.u_dc;
  const sextant::GatePattern pattern = controller.step(measurement, {sextant::ControlMode::torque, 15.0F});
  const bool driven = sextant::is_driven(pattern.last_state());
  std::printf("first pattern is %s\n", driven ? "driven" : "off");
  return driven ? 0 : 1;
}
