// Currents that are sampled in the middle of the carrier's period: the drive knows by its key.

#include <string>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"

namespace sextant {
namespace {

TEST(SamplingLead, ADriveThatKnowsItMakesItsTorqueWithEveryMethod) {
  for (const TestMachine& machine : {test_machines[1], test_machines[3], test_machines[5]}) {
    for (const char* controller :
         {"dtc", "duty_ratio", "predictive", "pwm_dtc", "feedback_linearisation", "foc", "deadbeat"}) {
      for (const double speed : {-0.6, 0.3}) {
        const double torque = 0.4 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        const MachineRun r{.controller = controller,
                           .period_us = 50,
                           .omega_m = speed * machine.base_speed(),
                           .end_s = 2.5 * machine.parameters.tau_r() + 0.3,
                           .lead_us = 25,
                           .torque = "[[0, " + std::to_string(torque) + "]]"};
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << speed);
        const MilResult result = run(machine, r);
        EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
        EXPECT_NEAR(result.metrics[Metric::torque_bias], 0.0, 0.005 * torque);
        EXPECT_EQ(result.final_state, DriveState::torque);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
