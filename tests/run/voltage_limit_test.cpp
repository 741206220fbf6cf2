// A drive on a shaft whose speed something else imposes, up to three times the speed at which the link's
// voltage suffices for its full flux.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

double tolerance(double torque) {
  return std::max(2.0, 0.05 * std::abs(torque));
}

/// Mean torque and mean reference over 20 ms: ripple has no say.
struct Means {
  double torque{};
  double reference{};
};
Means means(DriveRig& rig) {
  constexpr int periods = 800;
  Means seen;
  for (int k = 0; k < periods; ++k) {
    rig.step();
    seen.torque += rig.plant().tau_e() / periods;
    seen.reference += rig.telemetry.torque_reference / periods;
  }
  return seen;
}

/// Runs up from 100 rad/s, where the machine gets its flux, and stays at omega_m.
RigParameters on_the_way_to(double omega_m) {
  RigParameters p;
  const double sign = omega_m < 0.0 ? -1.0 : 1.0;
  p.load.imposed_speed =
      ProfileParameters{.shape = ProfileShape::linear,
                        .points = {{0.0, sign * 100.0}, {0.2, sign * 100.0}, {0.3, omega_m}, {2.0, omega_m}}};
  return p;
}

/// Starts with one torque for some time, then steps to another one and lets it settle. [N·m, s]
void step_torque(DriveRig& rig, double first, double first_s, double second, double settle_s) {
  rig.start();
  rig.torque = first;
  rig.run(first_s);
  rig.torque = second;
  rig.run(settle_s);
}

/// The mean torque follows its reference within the tolerance and `extra`, without a fault.
void expect_to_follow(DriveRig& rig, int means_taken, double extra) {
  for (int k = 0; k < means_taken; ++k) {
    const Means seen = means(rig);
    EXPECT_NEAR(seen.torque, seen.reference, tolerance(seen.reference) + extra)
        << "at " << rig.telemetry.omega_m << " rad/s";
    EXPECT_TRUE(gates_are_on(rig.drive().state()));
    EXPECT_EQ(rig.telemetry.latched, FaultSet{});
  }
}

/// The mean torque over 20 ms stays at its reference, and the reference at what is available.
void expect_delivery(DriveRig& rig) {
  for (int k = 0; k < 10; ++k) {
    const double mean = rig.watch(0.02).mean_torque;
    const Telemetry<double>& t = rig.telemetry;
    EXPECT_NEAR(mean, t.torque_reference, tolerance(t.torque_reference));
    const double available = rig.torque * t.omega_m < 0.0 ? t.torque_regenerating : t.torque_motoring;
    EXPECT_NEAR(std::abs(t.torque_reference), std::min(std::abs(rig.torque), available), 1e-9);
    const bool short_of_it = t.torque_reference != rig.torque;
    EXPECT_EQ(rig.drive().state(), short_of_it ? DriveState::derated : DriveState::torque);
    EXPECT_EQ(t.derating_cause == DeratingCause::voltage_limit, available < 150.0);
    EXPECT_EQ(t.latched, FaultSet{});
  }
}

TEST(VoltageLimit, ThePublishedTorqueIsDeliveredUpToThreeTimesBaseSpeed) {
  for (const bool delayed : {false, true}) {
    for (const double omega_m : {115.0, 130.0, 145.0, 160.0, -160.0, 200.0, 300.0, 400.0, -400.0}) {
      for (const double torque : {0.0, 2.0, -2.0, 15.0, -15.0, 60.0, -60.0, 150.0, -150.0}) {
        SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s" +
                     (delayed ? ", one period late" : ""));
        RigParameters p = on_the_way_to(omega_m);
        if (delayed) p.with_actuation_delay();
        DriveRig rig{p};
        step_torque(rig, omega_m < 0.0 ? -15.0 : 15.0, 0.35, torque, 0.06);
        expect_delivery(rig);
      }
    }
  }
}

// Rotor resistance and magnetising inductance, of which the voltage model and the available torque of the
// drive know nothing; the reserve and the present limit have to do.
TEST(VoltageLimit, AMachineThatDiffersFromTheParametersGetsLessFluxAndNoUncommandedTorque) {
  int derated = 0;
  for (const double r_r : {0.5, 1.5}) {
    for (const double l_m : {0.7, 1.3}) {
      for (const double omega_m : {140.0, 200.0, 300.0, 400.0}) {
        for (const double torque : {150.0, 15.0, -60.0, -150.0}) {
          SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s, R_r times " +
                       std::to_string(r_r) + ", L_m times " + std::to_string(l_m));
          RigParameters p = on_the_way_to(omega_m);
          p.stage.plant.machine.r_r *= r_r;
          p.stage.plant.machine.l_m *= l_m;
          DriveRig rig{p};
          step_torque(rig, 15.0, 0.35, torque, 0.15);
          expect_to_follow(rig, 10, 0.5);
          derated += rig.drive().state() == DriveState::derated ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GE(derated, 16);
}

TEST(VoltageLimit, TheTorqueHoldsWhileTheSpeedRunsAwayAndComesBack) {
  for (const double torque : {0.0, 20.0, 100.0, -50.0, -150.0}) {
    SCOPED_TRACE(torque);
    RigParameters p;
    p.load.imposed_speed = ProfileParameters{
        .shape = ProfileShape::linear,
        .points = {{0.0, 100.0}, {0.2, 100.0}, {0.5, 400.0}, {0.6, 400.0}, {0.9, 100.0}, {2.0, 100.0}}};
    DriveRig rig{p};
    step_torque(rig, 20.0, 0.1, torque, 0.05);
    expect_to_follow(rig, 40, 0.0);
    EXPECT_EQ(rig.drive().state(), DriveState::torque);
  }
}

TEST(VoltageLimit, TorqueStepsFromOneLimitToTheOtherNeitherPullOutNorTrip) {
  for (const double omega_m : {140.0, 200.0, 300.0, 400.0}) {
    SCOPED_TRACE(omega_m);
    DriveRig rig{on_the_way_to(omega_m)};
    rig.start();
    rig.torque = 15.0;
    rig.run(0.4);
    for (int k = 0; k < 10; ++k) {
      rig.torque = k % 2 == 0 ? -150.0 : 150.0;
      rig.run(0.02);
      const auto seen = rig.watch(0.02);
      EXPECT_NEAR(seen.mean_torque, rig.telemetry.torque_reference,
                  tolerance(rig.telemetry.torque_reference));
      EXPECT_LT(seen.peak_current, 130.0);
    }
    EXPECT_EQ(rig.telemetry.latched, FaultSet{});
  }
}

// A regenerating torque falls slowly at the voltage limit. Zero is no direction that lacks torque: the state
// says that the voltage holds the torque, and what is available stays.
TEST(VoltageLimit, OnTheWayToZeroTorqueThePublishedTorqueStaysAndTheStateShowsTheLag) {
  DriveRig rig{on_the_way_to(300.0)};
  rig.start();
  rig.torque = -60.0;
  rig.run(0.6);
  const double before = rig.telemetry.torque_motoring;
  ASSERT_GT(before, 20.0);
  rig.torque = 0.0;
  int derated = 0;
  for (int k = 0; k < 400; ++k) {
    rig.step();
    ASSERT_NEAR(rig.telemetry.torque_motoring, before, 0.05 * before) << k;
    if (rig.drive().state() == DriveState::torque) continue;
    ASSERT_EQ(rig.drive().state(), DriveState::derated) << k;
    ASSERT_EQ(rig.telemetry.derating_cause, DeratingCause::voltage_limit) << k;
    ASSERT_LT(rig.telemetry.torque_reached, 0.0) << k;
    ++derated;
  }
  EXPECT_GT(derated, 0);
  EXPECT_EQ(rig.drive().state(), DriveState::torque);
}

// Sampling adds what three active vectors move the current by.
constexpr double ripple = 7.0;  // [A]

TEST(CurrentLimit, HoldsTheCurrentThatTorqueTakesFromTheStartOnAlsoWithAWrongMachine) {
  for (const double l_m : {0.6, 1.0}) {
    for (const double omega_m : {-60.0, 0.0, 50.0, 160.0}) {
      for (const double torque : {150.0, -150.0}) {
        SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s, L_m times " +
                     std::to_string(l_m));
        RigParameters p = RigParameters::at_speed(omega_m);
        p.stage.plant.machine.l_m *= l_m;
        DriveRig rig{p};
        rig.start();
        rig.torque = torque;
        EXPECT_LT(rig.watch(0.2).peak_current, p.drive.motor.capability.current_limit + ripple);
        EXPECT_EQ(rig.telemetry.latched, FaultSet{});
        // Torque at the limit, once the surge is over with which the flux comes.
        p.drive.motor.capability.current_limit = 40.0;
        DriveRig narrow{p};
        narrow.start();
        narrow.torque = torque;
        narrow.run(0.4);
        const auto seen = narrow.watch(0.2);
        EXPECT_LT(seen.peak_current, 40.0 + ripple);
        EXPECT_GT(seen.peak_current, 40.0 - 2.0);
        EXPECT_EQ(narrow.drive().state(), DriveState::derated);
        EXPECT_EQ(narrow.telemetry.derating_cause, DeratingCause::current_limit);
      }
    }
  }
}

TEST(VoltageLimit, AnOverSpeedIsAFault) {
  DriveRig rig{on_the_way_to(500.0)};
  rig.start();
  rig.torque = 20.0;
  rig.run(0.29);  // 460 rad/s
  EXPECT_TRUE(makes_torque(rig.drive().state()));
  rig.run(0.02);
  EXPECT_EQ(rig.drive().state(), DriveState::fault);
  EXPECT_EQ(rig.telemetry.first_fault, Fault::over_speed);
  EXPECT_NEAR(rig.watch(0.01).mean_torque, 0.0, 0.01);
}

}  // namespace
}  // namespace sextant
