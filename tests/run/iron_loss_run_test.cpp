// The whole drive on a machine with iron loss: what it knows of it, and the torque that the shaft then gets.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

constexpr double flux = 1.1, fifty_hertz = 314.159, loss_w = 785;
/// Eddy currents that lose as much at the flux reference and 50 Hz without torque, as the drive and as the
/// plant count it, the latter across the voltage of the rotor flux (1 − σ) ψ_s.
constexpr double told_ohm = 1.5 * (fifty_hertz * flux) * (fifty_hertz * flux) / loss_w;
constexpr double unknown = std::numeric_limits<double>::infinity();

double eddy_ohm() {
  const InductionMachineParameters<> m;
  const double share = m.k_r() * m.l_m / m.l_s();
  return share * share * told_ohm;
}

struct Seen {
  double torque{};     ///< of the plant, mean [N·m]
  double estimate{};   ///< of the drive, at the end [N·m]
  double monitored{};  ///< by its monitor, at the end [N·m]
  bool tripped{};
};

template <class ControlMethod>
Seen run(double omega_m, double torque, double resistance) {
  RigParameters p = RigParameters::at_speed(omega_m);
  p.stage.plant.iron_loss.eddy_resistance = eddy_ohm();
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.controller.iron_loss_resistance = resistance;
  p.drive.torque_monitor.iron_loss_resistance = resistance;
  p.drive.magnetise_first = true;
  typename ControlMethod::Parameters c;
  static_cast<EstimatingController<double>::Parameters&>(c) = p.controller;
  DriveRigOf<ControlMethod> rig{p, c};
  rig.start();
  rig.run(0.3);
  rig.torque = torque;
  rig.run(0.3);
  Seen seen;
  seen.torque = rig.watch(0.1).mean_torque;
  seen.estimate = rig.telemetry.torque;
  seen.monitored = rig.telemetry.torque_monitored;
  seen.tripped = rig.telemetry.latched.any();
  return seen;
}

// P_fe = 3/2 (ω_e ψ)²/R_fe at constant flux, of which p P_fe/ω_e is torque against the rotation.
TEST(IronLossRun, ADriveThatDoesNotKnowItLacksTheTorqueOfTheLoss) {
  for (const double omega_m : {-100.0, 50.0, 100.0}) {
    for (const double torque : {0.0, 40.0}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, " << torque << " N·m");
      const Seen seen = run<FieldOrientedController<double>>(omega_m, torque, unknown);
      const double omega_e = 2 * omega_m;
      const double loss = 1.5 * omega_e * omega_e * flux * flux / told_ohm;
      EXPECT_FALSE(seen.tripped);
      EXPECT_NEAR(seen.torque, torque - 2 * loss / omega_e, 0.5);
    }
  }
}

TEST(IronLossRun, ADriveThatKnowsItMakesTheTorqueAtEverySpeed) {
  for (const double omega_m : {-200.0, -100.0, 0.0, 20.0, 100.0, 200.0}) {
    for (const double torque : {-40.0, 0.0, 40.0}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, " << torque << " N·m");
      const Seen seen = run<FieldOrientedController<double>>(omega_m, torque, told_ohm);
      EXPECT_FALSE(seen.tripped);
      EXPECT_NEAR(seen.torque, torque, 0.6);  // without: 6.4
      EXPECT_NEAR(seen.estimate, torque, 0.8);
      EXPECT_NEAR(seen.monitored, torque, 1.5);
    }
  }
}

// The power that the iron takes while the machine is magnetised looks like that of 2 Ω in the stator. In
// weakening, where the flux follows from R_s |i_s| beside the link voltage, that is 10 N·m.
TEST(IronLossRun, IdentificationDoesNotTakeTheKnownLossForAResistance) {
  using Foc = FieldOrientedController<double>;
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(run<Foc>(side * 300, side * -130, told_ohm).torque, side * -130, 3.0);
    EXPECT_GT(std::abs(run<Foc>(side * 300, side * -130, unknown).torque - side * -130), 8.0);
  }
}

TEST(IronLossRun, SoDoesDirectTorqueControl) {
  for (const double omega_m : {-100.0, 100.0}) {
    SCOPED_TRACE(testing::Message() << omega_m << " rad/s");
    EXPECT_NEAR(run<DirectTorqueController<double>>(omega_m, 40, told_ohm).torque, 40, 2.0);
    EXPECT_GT(std::abs(run<DirectTorqueController<double>>(omega_m, 40, unknown).torque - 40), 2.5);
  }
}

// The loss feeds back on the change of the flux that makes it: told a resistance far below that of any
// machine, of which R_r is a multiple, the estimate is wrong and finite.
TEST(IronLossRun, AResistanceBelowThatOfTheRotorLeavesTheEstimateFinite) {
  for (const double resistance : {0.3, 0.01}) {
    const Seen seen = run<FieldOrientedController<double>>(50.0, 20.0, resistance);
    EXPECT_TRUE(std::isfinite(seen.estimate) && std::isfinite(seen.monitored)) << resistance;
  }
}

}  // namespace
}  // namespace sextant
