// The controller and the plant's equations without a compiled library: a torque step in a closed loop.
#include <cmath>
#include <cstdio>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

int main() {
  using Plant = sextant::DrivePlant<>;
  const sextant::DirectTorqueController<>::Parameters parameters;
  sextant::DirectTorqueController<> controller{parameters};
  Plant plant{sextant::DrivePlantParameters<double>{}};
  sextant::FixedStepIntegrator<Plant> integrator;
  sextant::Measurement<double> measurement{.u_dc = 530.0};
  double mean = 0.0;
  for (int period = 0; period < 4000; ++period) {
    const sextant::GatePattern pattern = controller.step(measurement, {sextant::ControlMode::torque, 15.0});
    plant.set_inputs({.state = pattern.last_state(), .u_dc = measurement.u_dc, .imposed_speed = true});
    if (!integrator.advance(plant, parameters.period_ns)) return 1;
    measurement.i_abc = plant.i_abc();
    measurement.applied = pattern;
    if (period >= 2000) mean += plant.tau_e() / 2000.0;
  }
  std::printf("mean torque %.2f N·m of 15\n", mean);
  return std::abs(mean - 15.0) < 3.0 ? 0 : 1;
}
