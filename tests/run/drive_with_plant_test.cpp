// The drive with its plant as a whole, on virtual time.

#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

constexpr double settle_s = 0.15;  // the flux stands after 0.1 s

/// Mean torque error without trim of table-based control sampled at 25 µs, 15 N·m, 1.1 Wb; it is drawn
/// towards braking.
double untrimmed_bias(double omega_m) {
  const double w = std::abs(omega_m);
  const double size = w == 10.0 ? 0.3 : w == 50.0 ? 1.1 : 2.3;
  return omega_m > 0.0 ? -size : size;
}

void expect_steps_in_a_quadrant(const RigParameters& parameters, double torque, double omega_m) {
  SCOPED_TRACE("torque " + std::to_string(torque) + " at speed " + std::to_string(omega_m));
  DriveRig rig{parameters};
  rig.start();
  rig.torque = torque;
  rig.run(settle_s);
  EXPECT_NEAR(rig.watch(0.1).mean_torque, torque, 0.1);

  rig.torque = torque / 3.0;  // down and up again, the machine fluxed
  const auto down = rig.watch(0.02, torque);
  EXPECT_TRUE(down.reached_after_s.has_value());
  EXPECT_LT(down.reached_after_s.value_or(1.0), 1e-3);
  rig.torque = torque;
  const auto up = rig.watch(0.02, torque / 3.0);
  EXPECT_LT(up.reached_after_s.value_or(1.0), 1e-3);
  EXPECT_LT(up.peak_current, 60.0);
  EXPECT_EQ(rig.drive().state(), DriveState::torque);
}

TEST(DriveWithPlant, TorqueStepsSettleInAllFourQuadrants) {
  for (const IntegratorKind integrator : {IntegratorKind::fixed, IntegratorKind::cvode}) {
    SCOPED_TRACE(integrator == IntegratorKind::cvode ? "cvode" : "fixed");
    for (const double torque : {15.0, -15.0}) {
      for (const double omega_m : {50.0, -50.0}) {
        expect_steps_in_a_quadrant(RigParameters::at_speed(omega_m, integrator), torque, omega_m);
      }
    }
  }
}

TEST(DriveWithPlant, WithoutTrimTheBiasOfSamplingGrowsWithSpeedAndTurnsWithIt) {
  // Not -10 rad/s: braking this slowly the bias is -0.48 N·m, which does not follow the sign of the speed.
  for (const double omega_m : {10.0, 50.0, -50.0, 100.0, -100.0}) {
    SCOPED_TRACE(omega_m);
    RigParameters untrimmed = RigParameters::at_speed(omega_m);
    untrimmed.controller.torque_trim.time_constant = 0.0;
    DriveRig rig{untrimmed};
    rig.start();
    rig.torque = 15.0;
    rig.run(settle_s);
    EXPECT_NEAR(rig.watch(0.2).mean_torque - 15.0, untrimmed_bias(omega_m), 0.4);
  }
}

// The machine and its control know no preferred direction of rotation.
TEST(DriveWithPlant, BackwardsIsTheMirrorImageOfForwards) {
  for (const double omega_m : {10.0, -10.0, 50.0, -50.0}) {
    SCOPED_TRACE(omega_m);
    DriveRig forwards{RigParameters::at_speed(omega_m)};
    DriveRig backwards{RigParameters::at_speed(-omega_m)};
    for (DriveRig* rig : {&forwards, &backwards}) {
      rig->start();
      rig->torque = rig == &forwards ? 15.0 : -15.0;
      rig->run(settle_s);
    }
    EXPECT_NEAR(forwards.watch(0.2).mean_torque, -backwards.watch(0.2).mean_torque, 0.1);
  }
}

TEST(DriveWithPlant, ADelayOfOnePeriodIsCompensated) {
  for (const double torque : {15.0, -15.0}) {
    for (const double omega_m : {10.0, 50.0, -50.0}) {
      expect_steps_in_a_quadrant(RigParameters::at_speed(omega_m).with_actuation_delay(), torque, omega_m);
    }
  }
}

TEST(DriveWithPlant, BothReadingsOfTheComparatorFollowTheTorque) {
  for (const ComparatorReading reading : {ComparatorReading::relay, ComparatorReading::memoryless}) {
    SCOPED_TRACE(int(reading));
    RigParameters p = RigParameters::at_speed(50.0);
    p.controller.torque_comparator.reading = reading;
    DriveRig rig{p};
    rig.start();
    rig.torque = 15.0;
    EXPECT_LT(rig.watch(settle_s).reached_after_s.value_or(1.0), 5e-3);
    EXPECT_NEAR(rig.watch(0.1).mean_torque, 15.0, 0.1);
  }
}

TEST(DriveWithPlant, FifteenNewtonMetresFromADeadMachineTakeAboutThreeMilliseconds) {
  for (const double torque : {15.0, -15.0}) {
    SCOPED_TRACE(torque);
    DriveRig rig;
    rig.start();
    rig.torque = torque;
    const auto start = rig.watch(0.2);
    ASSERT_TRUE(start.reached_after_s.has_value());
    EXPECT_GT(*start.reached_after_s, 2.5e-3);
    EXPECT_LT(*start.reached_after_s, 3.5e-3);
    EXPECT_GT(start.peak_current, 70.0);
    EXPECT_LT(start.peak_current, 110.0);
    EXPECT_NEAR(magnitude(rig.plant().psi_s()), 1.1, 0.05);
  }
}

// Sectors that start on V1 instead of being centred on it: the second reading of the paper's example.
TEST(DriveWithPlant, SectorsThatStartOnTheFirstVectorCannotStartBackwards) {
  RigParameters p;
  p.controller.sector.sector_start_deg = 0.0;
  for (const double torque : {15.0, -15.0}) {
    SCOPED_TRACE(torque);
    DriveRig rig{p};
    rig.start();
    rig.torque = torque;
    EXPECT_EQ(rig.watch(0.1).reached_after_s.has_value(), torque > 0.0);
  }
}

TEST(DriveWithPlant, MagnetisingFirstSparesTheSurgeOfTheStart) {
  RigParameters p;
  p.drive.magnetise_first = true;
  p.controller.magnetiser.hand_over_current = 16.0;
  DriveRig rig{p};
  rig.start();
  rig.torque = 15.0;
  double peak = 0.0;
  while (rig.drive().state() == DriveState::magnetising && rig.t_ns < 200'000'000) {
    rig.step();
    peak = std::max(peak, magnitude(rig.plant().i_s()));
    EXPECT_LT(std::abs(rig.plant().tau_e()), 1.0) << "direct current makes no torque at rest";
  }
  ASSERT_EQ(rig.drive().state(), DriveState::torque);
  EXPECT_LT(peak, p.controller.magnetiser.current_limit + 3.0);  // and what one period adds
  const double at_hand_over = magnitude(rig.plant().i_s());
  EXPECT_LE(at_hand_over, p.controller.magnetiser.hand_over_current);
  EXPECT_NEAR(magnitude(rig.plant().psi_s()), 1.1, 0.06);
  const auto step = rig.watch(0.05);
  EXPECT_LT(step.reached_after_s.value_or(1.0), 1.5e-3);
  EXPECT_LT(step.peak_current, p.controller.magnetiser.hand_over_current + 15.0);
}

TEST(DriveWithPlant, DisabledAtSpeedTheCurrentsDieAndTheMachineIsCaughtAgain) {
  for (const double omega_m : {50.0, -50.0}) {
    SCOPED_TRACE(omega_m);
    DriveRig rig{RigParameters::at_speed(omega_m)};
    rig.start();
    rig.torque = 15.0;
    rig.run(settle_s);
    const double psi_r = magnitude(rig.plant().psi_r());

    rig.enable = false;
    rig.run(0.005);
    EXPECT_EQ(rig.drive().state(), DriveState::ready);
    EXPECT_EQ(rig.telemetry.pattern.last_state(), gates_off);
    EXPECT_LT(magnitude(rig.plant().i_s()), 1e-6);
    rig.run(0.025);
    const double tau_r = InductionMachineParameters<>{}.tau_r();
    EXPECT_NEAR(magnitude(rig.plant().psi_r()), psi_r * std::exp(-0.03 / tau_r), 0.02 * psi_r);
    EXPECT_LT(magnitude(rig.plant().i_s()), 1e-6);

    rig.enable = true;
    const auto caught = rig.watch(0.03);
    ASSERT_TRUE(caught.reached_after_s.has_value());
    EXPECT_LT(*caught.reached_after_s, 5e-3);
    EXPECT_LT(caught.peak_current, 65.0);
    rig.run(settle_s);
    EXPECT_NEAR(rig.watch(0.1).mean_torque, 15.0, 0.1);
  }
}

TEST(DriveWithPlant, TheEstimateIsThePlantsFluxAfterASecond) {
  DriveRig rig{RigParameters::at_speed(30.0)};
  rig.start();
  rig.torque = 15.0;
  rig.run(1.0);
  EXPECT_LT(magnitude(rig.telemetry.psi_s - rig.plant().psi_s()), 1e-3);
  EXPECT_NEAR(rig.telemetry.torque, rig.plant().tau_e(), 0.1);
}

// Between two samples currents are nearly straight lines: their squares have the mean (x² + xy + y²)/3.
double mean_square(SpaceVector<> x, SpaceVector<> y) {
  return (dot(x, x) + dot(x, y) + dot(y, y)) / 3.0;
}

TEST(DriveWithPlant, ThePowerFromTheLinkIsShaftPowerAndCopperLoss) {
  for (const double torque : {15.0, -15.0}) {
    SCOPED_TRACE(torque);
    DriveRig rig{RigParameters::at_speed(50.0)};
    rig.start();
    rig.torque = torque;
    rig.run(0.3);
    const InductionMachine<double>& machine = rig.plant().machine();
    const auto rotor = [&] { return machine.rotor_current(rig.plant().psi_s(), rig.plant().psi_r()); };
    const double field_before = rig.plant().magnetic_energy();
    double link = 0.0;
    double shaft = 0.0;
    double copper = 0.0;
    constexpr int periods = 40'000;
    for (int k = 0; k < periods; ++k) {
      const auto i_s = rig.plant().i_s();
      const auto i_r = rotor();
      const double tau_e = rig.plant().tau_e();
      rig.step();
      const double dt = DriveRig::period_s;
      link += rig.telemetry.i_dc * rig.telemetry.u_dc * dt;
      shaft += 0.5 * (tau_e + rig.plant().tau_e()) * rig.plant().omega_m() * dt;
      copper += 1.5 * dt * (0.435 * mean_square(i_s, rig.plant().i_s()) + 0.816 * mean_square(i_r, rotor()));
    }
    const double field = rig.plant().magnetic_energy() - field_before;
    EXPECT_GT(copper, 50.0);
    EXPECT_NEAR(link, shaft + copper + field, 0.02 * (std::abs(shaft) + copper));
  }
}

TEST(DriveWithPlant, OverCurrentTurnsTheGatesOffAndTheCurrentsDie) {
  RigParameters p;
  p.drive.protection.over_current = 50.0;
  DriveRig rig{p};
  rig.start();
  rig.torque = 15.0;
  while (rig.drive().state() != DriveState::fault && rig.t_ns < 20'000'000) rig.step();
  ASSERT_EQ(rig.drive().state(), DriveState::fault);
  EXPECT_TRUE(rig.telemetry.latched.test(Fault::over_current));
  EXPECT_EQ(rig.telemetry.pattern.last_state(), gates_off);
  EXPECT_LT(magnitude(rig.plant().i_s()), 50.0 + 10.0) << "the trip must come within a period";
  rig.run(0.005);
  EXPECT_LT(magnitude(rig.plant().i_s()), 1e-6);
  EXPECT_EQ(rig.drive().state(), DriveState::fault) << "the fault latches, the enable notwithstanding";
}

// A late wake-up of a millisecond in every hundred: the drive must come back each time.
TEST(DriveWithPlant, AMissedMillisecondDoesNotLoseTheMachine) {
  for (const double omega_m : {0.0, 50.0, -50.0}) {
    SCOPED_TRACE(omega_m);
    DriveRig rig{RigParameters::at_speed(omega_m)};
    rig.start();
    rig.torque = 15.0;
    rig.run(settle_s);
    for (int k = 0; k < 5; ++k) {
      rig.t_ns += 1'000'000;
      const auto after = rig.watch(0.1);
      EXPECT_LT(after.reached_after_s.value_or(1.0), 5e-3);
      EXPECT_LT(after.peak_current, 60.0);
      EXPECT_LT(magnitude(rig.telemetry.psi_s - rig.plant().psi_s()), 0.02);
    }
    EXPECT_EQ(rig.drive().state(), DriveState::torque);
  }
}

// A gap of many periods reaches the estimator as one pattern.
TEST(DriveWithPlant, AGapOfManyPeriodsAtSpeedLosesNeitherTheFluxNorTheMachine) {
  for (const double omega_m : {100.0, 130.0, -130.0}) {
    for (const int gap_ms : {1, 2, 5, 10, 20, 50}) {
      SCOPED_TRACE(testing::Message() << gap_ms << " ms at " << omega_m << " rad/s");
      DriveRig rig{RigParameters::at_speed(omega_m)};
      rig.start();
      rig.torque = 15.0;
      rig.run(0.3);
      const double torque = rig.watch(0.1).mean_torque;
      rig.t_ns += gap_ms * 1'000'000;
      rig.step();
      EXPECT_LT(magnitude(rig.telemetry.psi_s - rig.plant().psi_s()), 0.002);
      const auto after = rig.watch(0.1);
      EXPECT_LT(after.peak_current, gap_ms > 20 ? 95.0 : 60.0)
          << "after 50 ms the flux has to be built up anew";
      EXPECT_NEAR(after.mean_torque, torque, 1.0);
      EXPECT_EQ(rig.drive().state(), DriveState::torque);
    }
  }
}

TEST(DriveWithPlant, AGapInWhichTheSpeedChangesDoesNotTurnTheFluxAway) {
  RigParameters p;
  p.load.imposed_speed =
      ProfileParameters{.shape = ProfileShape::linear, .points = {{0.0, 20.0}, {0.5, 120.0}}};
  for (const int gap_ms : {5, 20, 50}) {
    SCOPED_TRACE(gap_ms);
    DriveRig rig{p};
    rig.start();
    rig.torque = 15.0;
    rig.run(0.3);
    rig.t_ns += gap_ms * 1'000'000;
    rig.step();
    EXPECT_LT(magnitude(rig.telemetry.psi_s - rig.plant().psi_s()), 0.01);
  }
}

}  // namespace
}  // namespace sextant
