// The torque monitor in a drive with its plant, against the plant's torque.

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"

namespace sextant {
namespace {

RigParameters rig_at(double omega_m) {
  RigParameters p = RigParameters::at_speed(omega_m, IntegratorKind::exact);
  p.drive.protection.over_current = 250.0;
  p.drive.protection.over_speed = 400.0;
  return p;
}

bool monitor_tripped(const DriveRig& rig) {
  return rig.telemetry.latched.test(Fault::torque_plausibility);
}

TEST(TorqueMonitorRun, TheMonitoredTorqueIsThatOfThePlant) {
  for (const double omega_m : {-100.0, -10.0, 0.0, 50.0, 100.0}) {
    for (const double torque : {-60.0, 2.0, 15.0, 130.0}) {
      SCOPED_TRACE(std::to_string(omega_m) + " rad/s, " + std::to_string(torque) + " N·m");
      DriveRig rig{rig_at(omega_m)};
      rig.start();
      rig.torque = torque;
      rig.run(0.15);
      double monitored = 0.0;
      double delivered = 0.0;
      constexpr int periods = 4000;
      for (int k = 0; k < periods; ++k) {
        rig.step();
        monitored += rig.telemetry.torque_monitored / periods;
        delivered += rig.plant().tau_e() / periods;
      }
      EXPECT_NEAR(monitored, delivered, 0.01 * std::abs(delivered) + 0.2);
      EXPECT_FALSE(monitor_tripped(rig));
    }
  }
}

TEST(TorqueMonitorRun, AStartFromADeadMachineIsNoFault) {
  for (const bool magnetise_first : {false, true}) {
    for (const double omega_m : {-100.0, -4.0, 0.0, 50.0, 100.0}) {
      for (const double torque : {-130.0, -15.0, 15.0, 60.0, 130.0}) {
        SCOPED_TRACE(std::to_string(omega_m) + " rad/s, " + std::to_string(torque) + " N·m");
        RigParameters p = rig_at(omega_m);
        p.drive.magnetise_first = magnetise_first;
        DriveRig rig{p};
        rig.start();
        rig.torque = torque;
        rig.run(0.2);
        EXPECT_FALSE(rig.telemetry.latched.any());
        EXPECT_EQ(rig.drive().state(), DriveState::torque);
      }
    }
  }
}

// The monitor knows the machine less well than the controller, as far as its bands allow for.
TEST(TorqueMonitorRun, RandomStepsOfTheCommandAreNoFaultWithWrongParametersOfTheMonitorEither) {
  constexpr unsigned seed = 20240611;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> torque{-130.0, 130.0};
  for (const double r_s : {0.5, 1.5}) {
    for (const double r_r : {0.5, 1.0, 1.5}) {
      for (const double l_m : {0.7, 1.3}) {
        for (const double omega_m : {-50.0, 0.0, 7.0, 100.0}) {
          SCOPED_TRACE(testing::Message() << r_s << ' ' << r_r << ' ' << l_m << ", " << omega_m << " rad/s");
          RigParameters p = rig_at(omega_m);
          p.drive.torque_monitor.machine.r_s *= r_s;
          p.drive.torque_monitor.machine.r_r *= r_r;
          p.drive.torque_monitor.machine.l_m *= l_m;
          DriveRig rig{p};
          rig.start();
          for (int k = 0; k < 40; ++k) {
            rig.torque = torque(random);
            rig.run(0.012);
          }
          EXPECT_FALSE(monitor_tripped(rig));
        }
      }
    }
  }
}

TEST(TorqueMonitorRun, GatesOffOnATurningMachineAndTorqueAgainIsNoFault) {
  for (const double omega_m : {-100.0, 30.0}) {
    for (const double off_s : {0.002, 0.03, 0.3}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, off for " << off_s << " s");
      DriveRig rig{rig_at(omega_m)};
      rig.start();
      rig.torque = 60.0;
      rig.run(0.15);
      rig.enable = false;
      rig.run(off_s);
      EXPECT_EQ(rig.drive().state(), DriveState::ready);
      rig.enable = true;
      rig.run(0.15);
      EXPECT_FALSE(rig.telemetry.latched.any());
      EXPECT_EQ(rig.drive().state(), DriveState::torque);
    }
  }
}

// The failure of the voltage model with a wrong R_s: the torque drifts off, unseen by the controller.
TEST(TorqueMonitorRun, TorqueThatDriftsOffUnderAWrongStatorResistanceIsAFault) {
  struct Case {
    double omega_m;
    double r_s;  // of the controller and the monitor, times that of the machine
  };
  for (const Case c :
       {Case{50.0, 1.2}, Case{-50.0, 1.2}, Case{100.0, 1.2}, Case{100.0, 1.5}, Case{20.0, 1.5}}) {
    SCOPED_TRACE(testing::Message() << c.omega_m << " rad/s, R_s x " << c.r_s);
    RigParameters p = rig_at(c.omega_m);
    p.controller.machine.r_s *= c.r_s;
    p.drive.torque_monitor.machine.r_s *= c.r_s;
    DriveRig rig{p};
    rig.start();
    rig.torque = std::copysign(15.0, c.omega_m);
    double seconds_off = 0.0;  // of the mean torque of a millisecond, without a break
    double longest_off = 0.0;
    for (int k = 0; k < 2000 && !monitor_tripped(rig); ++k) {
      double mean = 0.0;
      for (int n = 0; n < 40 && !monitor_tripped(rig); ++n) {
        rig.step();
        mean += rig.plant().tau_e() / 40.0;
      }
      // Twice the limit: the band is no wider than that at these speeds and currents.
      seconds_off = std::abs(mean - rig.torque) > 40.0 ? seconds_off + 1e-3 : 0.0;
      longest_off = std::max(longest_off, seconds_off);
    }
    EXPECT_TRUE(monitor_tripped(rig));
    EXPECT_LT(longest_off, 0.0101);
  }
}

TEST(TorqueMonitorRun, WithoutMonitorAndProtectionsTheSameDriftStaysUnseen) {
  RigParameters p = rig_at(50.0);
  p.controller.machine.r_s *= 1.2;
  p.drive.torque_monitor.enabled = false;
  p.drive.protection.flux_lost_share = 0;
  p.drive.protection.speed_error = 1e6;
  DriveRig rig{p};
  rig.start();
  rig.torque = 15.0;
  rig.run(1.0);
  EXPECT_LT(rig.watch(1.0).mean_torque, -40.0);
  EXPECT_FALSE(rig.telemetry.latched.any());
}

}  // namespace
}  // namespace sextant
