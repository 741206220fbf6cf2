// A whole drive whose current sensor has an offset while the gates are off.

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

constexpr double limit = Protection<>::Parameters{}.current_offset;

TEST(CurrentOffsetRun, WithinTheLimitTheDriveMakesTorque) {
  RigParameters p = RigParameters::at_speed(40.0);
  p.stage.io.sensors.phases[0].offset = 0.95 * limit;
  p.stage.io.sensors.phases[1].offset = -0.95 * limit;
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  DriveRig rig{p};
  rig.run(0.1);
  rig.start();
  rig.torque = 15.0;
  rig.run(0.1);
  EXPECT_EQ(rig.drive().state(), DriveState::torque);
  EXPECT_FALSE(rig.telemetry.latched.any());
  EXPECT_NEAR(rig.watch(0.02).mean_torque, 15.0, 0.5);
}

TEST(CurrentOffsetRun, BeyondTheLimitIsAFaultThatLatchesAndIsLeftByResetDisableEnable) {
  RigParameters p = RigParameters::at_speed(40.0);
  p.stage.io.fault = {.kind = PlantFaultKind::current_drift, .at_ns = 50'000'000, .until_ns = 200'000'000};
  p.stage.io.fault.drift = 20.0 * limit;
  DriveRig rig{p};
  rig.run(0.1);
  EXPECT_FALSE(rig.telemetry.latched.any()) << "the mean follows the drift";
  rig.run(0.09);
  FaultSet expected;
  expected.set(Fault::current_sensor);
  EXPECT_EQ(rig.telemetry.latched, expected);
  EXPECT_EQ(rig.drive().state(), DriveState::fault);
  rig.fault_reset = true;
  rig.run(0.005);
  EXPECT_EQ(rig.drive().state(), DriveState::fault) << "while the offset is there";
  rig.fault_reset = false;
  rig.run(0.1);
  EXPECT_EQ(rig.telemetry.active, FaultSet{});
  EXPECT_EQ(rig.drive().state(), DriveState::fault) << "it has latched";
  rig.start();
  EXPECT_EQ(rig.drive().state(), DriveState::fault) << "disable, enable";
  rig.enable = false;
  rig.fault_reset = true;
  rig.run_periods(2);
  rig.fault_reset = false;
  EXPECT_EQ(rig.telemetry.latched, FaultSet{});
  rig.start();
  EXPECT_TRUE(makes_torque(rig.drive().state()));
}

}  // namespace
}  // namespace sextant
