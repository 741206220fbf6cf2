// What a drive does after a trip by measurements that cannot be: reset, disable, enable on the turning
// machine.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "run/machine_rig.hpp"

namespace sextant {
namespace {

/// What spoils the measurements, and for how long [s]; 0: one period.
struct BadReadings {
  const char* name;
  Spoil spoil;
  double seconds;
};

/// trip: level of OVER_CURRENT [A].
std::array<BadReadings, 6> bad_readings(double trip) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto currents = [](double i) {
    return [i](Measurement<double>& m) { m.i_abc = {i, -0.5 * i, -0.5 * i}; };
  };
  return {{{"a current of 1e308 A", currents(1e308), 0.0},
           {"a link of 1e300 V", [](Measurement<double>& m) { m.u_dc = 1e300; }, 0.0},
           {"a speed of 1e6 rad/s", [](Measurement<double>& m) { m.omega_m = 1e6; }, 0.0},
           {"a speed that is no number", [](Measurement<double>& m) { m.omega_m = nan; }, 0.0},
           {"currents at ten times their range", currents(100 * trip), 0.4},
           {"currents at five times their trip", currents(5 * trip), 0.4}}};
}

// A model of the flux that had taken up such a reading would start from a flux that is not there, or would
// have none in a machine that still has its own.
TEST(AfterTrip, TheNextStartIsThatOfADriveWithoutFault) {
  for (const TestMachine& machine : {test_machines[0], test_machines[1], test_machines[3]}) {
    for (const char* controller : {"dtc", "foc"}) {
      const MachineRun run{.controller = controller, .period_us = 100, .omega_m = 0.3 * machine.base_speed()};
      const double tau_r = machine.parameters.tau_r();
      for (const BadReadings& fault : bad_readings(MachineRig{machine, run}.limits().over_current)) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << fault.name);
        MachineRig rig{machine, run};
        rig.torque = 0.3 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        ASSERT_TRUE(rig.start(3 * tau_r));
        rig.run(0.1);
        const double first_peak = rig.peak_current;
        rig.spoil = fault.spoil;
        rig.run(std::max(fault.seconds, 1e-6));
        rig.spoil = {};
        ASSERT_EQ(rig.state(), DriveState::fault);
        rig.peak_current = 0.0;
        rig.reset();
        ASSERT_TRUE(rig.start(3 * tau_r));
        EXPECT_LT(rig.peak_current, 1.2 * first_peak);
        rig.run(0.02);
        EXPECT_NEAR(rig.mean_torque(0.05), rig.torque, 0.03 * rig.torque);
        EXPECT_EQ(rig.state(), DriveState::torque);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
