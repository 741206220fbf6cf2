// A drive that is switched on to a machine that turns freely and has a flux that the drive knows nothing of.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "run/machine_rig.hpp"

namespace sextant {
namespace {

struct Start {
  const char* controller;
  double speed;  ///< by base speed [-]
  double flux;   ///< of the rotor, by the flux reference [-]
};

/// The shaft drives a flywheel, so that its speed stays.
ScenarioConfig turning(const TestMachine& machine, const Start& start) {
  ScenarioConfig config = machine_config(
      machine,
      {.controller = start.controller, .period_us = machine.parameters.sigma_l_s() < 1e-4 ? 10 : 50});
  config.scenario.load = {};
  config.drive.plant.plant.initial = {start.speed * machine.base_speed(), start.flux * machine.psi};
  config.drive.plant.plant.machine.inertia *= 1000;
  return config;
}

double torque_of(const TestMachine& machine) {
  return 0.3 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
}

TEST(FlyingStartRun, ADriveStartsOntoATurningMachineWithAResidualFlux) {
  constexpr std::array methods{
      "dtc", "predictive", "duty_ratio", "foc", "pwm_dtc", "deadbeat", "feedback_linearisation"};
  std::size_t n = 0;
  for (const TestMachine& machine : test_machines) {
    for (const double speed : {-0.8, 0.3, 0.6}) {
      const Start start{methods[n++ % methods.size()], speed, 0.2};
      SCOPED_TRACE(testing::Message() << machine.name << ", " << start.controller << ", " << speed);
      MachineRig rig{turning(machine, start)};
      ASSERT_TRUE(rig.start(3.0 * machine.parameters.tau_r() + 1.0));
      EXPECT_LT(rig.peak_current, rig.limits().over_current);
      rig.torque = torque_of(machine);
      rig.run(0.05);
      EXPECT_NEAR(rig.mean_torque(0.02), rig.torque, 0.1 * rig.torque);
      EXPECT_NEAR(rig.telemetry.omega_m, speed * machine.base_speed(), 0.01 * machine.base_speed());
      EXPECT_FALSE(rig.telemetry.latched.any());
    }
  }
}

// Of half of the flux the induced voltage drives a current that its prediction does not know of: the drive
// takes it for a wrong reading and turns the gates off, below its current limit. It starts once the flux has
// decayed.
TEST(FlyingStartRun, ALargeUnknownFluxTurnsTheGatesOffUntilItHasDecayed) {
  for (const TestMachine& machine : {test_machines[1], test_machines[5]}) {
    for (const char* controller : {"dtc", "foc"}) {
      SCOPED_TRACE(testing::Message() << machine.name << ", " << controller);
      MachineRig rig{turning(machine, {controller, -0.8, 0.5})};
      EXPECT_FALSE(rig.start(0.1));
      EXPECT_EQ(rig.telemetry.first_fault, Fault::current_sensor);
      EXPECT_LT(rig.peak_current, 0.25 * rig.limits().over_current);
      rig.run(2.0 * machine.parameters.tau_r());
      rig.reset();
      ASSERT_TRUE(rig.start(3.0 * machine.parameters.tau_r() + 1.0));
      rig.torque = torque_of(machine);
      rig.run(0.05);
      EXPECT_NEAR(rig.mean_torque(0.02), rig.torque, 0.03 * rig.torque);
    }
  }
}

}  // namespace
}  // namespace sextant
