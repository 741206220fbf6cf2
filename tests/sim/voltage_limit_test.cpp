// A drive on a shaft whose speed something else imposes, up to and beyond the speed at which the link's
// voltage suffices for its flux.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "sim/drive_rig.hpp"

namespace sextant {
namespace {

/// At one speed throughout; the drive is enabled where the machine is fluxed as far as it can be.
struct Held {
  double mean_torque;
  double admitted;
  double motoring;
  double regenerating;
  bool gates_on;
};

/// The speed rises from 100 rad/s, where the machine was fluxed, to omega_m, and stays.
Held hold(double omega_m, double torque) {
  RigParameters p;
  const double top = std::max(omega_m, 100.1);
  p.load.imposed_speed = ProfileParameters{.shape = ProfileShape::linear,
                                           .points = {{0.0, 100.0}, {0.2, 100.0}, {0.3, top}, {2.0, top}}};
  p.drive.protection.over_speed = 1000.0;
  DriveRig rig{p};
  rig.start();
  rig.torque = torque;
  rig.run(0.5);
  const auto seen = rig.watch(0.2);
  return {.mean_torque = seen.mean_torque,
          .admitted = rig.telemetry.torque_reference,
          .motoring = rig.telemetry.torque_motoring,
          .regenerating = rig.telemetry.torque_regenerating,
          .gates_on = gates_are_on(rig.drive().state())};
}

// Sampling at 25 µs draws the mean towards braking by up to 2.9 N·m at any speed, far below the limit too.
constexpr double bias_of_sampling = 3.0;

TEST(VoltageLimit, TheReferenceIsDeliveredOrTheGatesAreOff) {
  int on = 0;
  int off = 0;
  for (const double omega_m :
       {105.0, 115.0, 125.0, 130.0, 134.0, 136.0, 138.0, 140.0, 145.0, 150.0, 160.0, 170.0}) {
    for (const double torque : {0.0, 5.0, 20.0, 50.0, 100.0, 130.0, 150.0, -20.0, -100.0, -150.0}) {
      SCOPED_TRACE(std::to_string(torque) + " N·m asked at " + std::to_string(omega_m) + " rad/s");
      const Held held = hold(omega_m, torque);
      if (held.gates_on) {
        ++on;
        EXPECT_NEAR(held.mean_torque, held.admitted,
                    std::max(bias_of_sampling, 0.05 * std::abs(held.admitted)));
        EXPECT_LE(held.admitted, held.motoring);
        EXPECT_GE(held.admitted, -held.regenerating);
      } else {
        ++off;
        EXPECT_NEAR(held.mean_torque, 0.0, 0.01);
        EXPECT_EQ(held.motoring, 0.0);
        EXPECT_EQ(held.regenerating, 0.0);
      }
    }
  }
  EXPECT_GE(on, 60);
  EXPECT_GE(off, 50);
}

// Mean over each stretch of 5 ms, in which the ripple of sampling has no say.
TEST(VoltageLimit, TorqueIsNeverOfTheWrongSignWhileTheSpeedRunsAwayAndComesBack) {
  for (const double torque : {20.0, 100.0, -50.0}) {
    SCOPED_TRACE(torque);
    RigParameters p;
    p.load.imposed_speed = ProfileParameters{
        .shape = ProfileShape::linear,
        .points = {{0.0, 100.0}, {0.2, 100.0}, {0.3, 160.0}, {0.6, 160.0}, {0.7, 100.0}, {2.0, 100.0}}};
    DriveRig rig{p};
    rig.start();
    rig.torque = torque;
    rig.run(0.1);
    for (int k = 0; k < 160; ++k) {
      const auto seen = rig.watch(5e-3);
      const double along = torque > 0.0 ? seen.mean_torque : -seen.mean_torque;
      EXPECT_GT(along, -bias_of_sampling) << "at " << rig.telemetry.omega_m << " rad/s";
      EXPECT_LT(seen.peak_current, 160.0) << "torque returns to a machine that has lost its flux";
      EXPECT_EQ(rig.telemetry.latched, FaultSet{});
    }
    EXPECT_EQ(rig.drive().state(), DriveState::torque);
    EXPECT_NEAR(rig.watch(0.1).mean_torque, torque, bias_of_sampling);
  }
}

TEST(VoltageLimit, AnOverSpeedIsAFaultAndTheTorqueIsGoneBeforeIt) {
  RigParameters p;
  p.load.imposed_speed =
      ProfileParameters{.shape = ProfileShape::linear, .points = {{0.0, 100.0}, {0.2, 100.0}, {0.3, 175.0}}};
  DriveRig rig{p};
  rig.start();
  rig.torque = 20.0;
  rig.run(0.28);  // 160 rad/s
  EXPECT_EQ(rig.drive().state(), DriveState::ready);
  rig.run(0.05);
  EXPECT_EQ(rig.drive().state(), DriveState::fault);
  EXPECT_EQ(rig.telemetry.first_fault, Fault::over_speed);
  EXPECT_NEAR(rig.watch(0.01).mean_torque, 0.0, 0.01);
}

}  // namespace
}  // namespace sextant
