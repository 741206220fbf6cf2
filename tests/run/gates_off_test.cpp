// What the current sensors' offset makes of the currents that the diodes carry after the gates went off at
// speed, over machines, methods and ways to turn the gates off.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "run/machine_rig.hpp"

namespace sextant {
namespace {

enum class Off { by_disable, by_trip, by_sag };

constexpr const char* name_of(Off off) {
  return off == Off::by_disable ? "disable" : off == Off::by_trip ? "trip" : "sag of the link";
}

struct OffCase {
  const char* controller;
  double speed;   ///< by base speed [-]
  double torque;  ///< by the torque limit [-]
  Off off;
};

/// Gates go off under torque; the link has 0.3 of its voltage from then on with a sag.
std::unique_ptr<MachineRig> running(const TestMachine& machine, const OffCase& c) {
  const double begin_s = std::max(0.3, 2.5 * machine.parameters.tau_r());
  ScenarioConfig config =
      machine_config(machine, {.controller = c.controller,
                               .period_us = machine.parameters.sigma_l_s() < 1e-4 ? 20 : 50,
                               .omega_m = c.speed * machine.base_speed()});
  SimulatedDriveIoParameters& io = config.drive.plant.io;
  if (c.off == Off::by_sag) {
    io.fault = {.kind = PlantFaultKind::link_sag, .at_ns = std::llround((begin_s + 0.1) * 1e9)};
    io.fault.sag_voltage = 0.3 * machine.u_dc;
  }
  auto found = std::make_unique<MachineRig>(config);
  MachineRig& rig = *found;
  rig.run(0.05);
  rig.torque = c.torque * config.drive.drive.command.torque_limit;
  const bool makes = rig.start(begin_s);  // far above base speed the flux may still be on its way
  EXPECT_TRUE(makes || gates_are_on(rig.state()) || std::abs(c.speed) > 2.0);
  rig.run(std::max(0.0, begin_s + 0.1 - rig.time_s()));
  if (c.off == Off::by_disable) rig.enable = false;
  if (c.off == Off::by_trip) rig.external.set(Fault::bus_off);
  rig.run(2e-3);
  rig.external = {};
  return found;
}

TEST(GatesOff, CurrentsOfTheDiodesAreNoOffset) {
  int n = 0;
  for (const TestMachine& machine : test_machines) {
    for (const Off off : {Off::by_disable, Off::by_trip, Off::by_sag}) {
      for (const double speed : {-0.5, 0.9, 1.3, -2.0, 3.0}) {
        const char* controller = n++ % 2 == 0 ? "foc" : "dtc";
        SCOPED_TRACE(testing::Message()
                     << machine.name << ", " << controller << ", " << speed << ", " << name_of(off));
        const auto made = running(machine, {controller, speed, n % 3 == 0 ? -0.6 : 0.6, off});
        MachineRig& rig = *made;
        EXPECT_NE(rig.state(), DriveState::torque);
        rig.run(3 * machine.parameters.tau_r());
        EXPECT_FALSE(rig.telemetry.latched.test(Fault::current_sensor));
      }
    }
  }
}

// An offset of a sensor is still one: within its limit it is removed, beyond it is found as soon as the
// currents have died away.
TEST(GatesOff, AnOffsetBeyondTheLimitIsFoundWithin45MsOfTheEndOfTheCurrents) {
  int n = 0;
  for (const TestMachine& machine :
       {test_machines[0], test_machines[1], test_machines[5], test_machines[7]}) {
    for (const double offset : {-1.3, -0.9, 0.9, 1.3, 8.0}) {
      for (const double speed : {0.0, 0.9, -2.0}) {
        const char* controller = n++ % 2 == 0 ? "foc" : "dtc";
        const bool is_broken = std::abs(offset) > 1;
        SCOPED_TRACE(testing::Message()
                     << machine.name << ", " << controller << ", " << speed << ", " << offset);
        const auto made = running(machine, {controller, speed, 0.3, Off::by_disable});
        MachineRig& rig = *made;
        const double off = offset * rig.limits().current_offset;
        rig.spoil = [off](Measurement<double>& m) { m.i_abc.a += off; };
        rig.run(0.045);
        EXPECT_EQ(rig.telemetry.latched.test(Fault::current_sensor), is_broken);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
