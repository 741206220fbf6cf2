// The whole drive on a machine whose main flux saturates: what it knows of the curve, and what it then does.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "run/machine_run.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

using Foc = FieldOrientedController<double>;

/// At the flux reference the inductance is half of what it is at small fluxes.
constexpr SaturationParameters<> curve{.knee = 1.1, .exponent = 7, .machine_flux = 1.1};

struct Seen {
  double torque{};  ///< mean, once the flux has settled [N·m]
  bool tripped{};
};

Seen run(double omega_m, double torque, const SaturationParameters<>& known, double r_r = 1) {
  RigParameters p = RigParameters::at_speed(omega_m);
  p.stage.plant.saturation = curve;
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.controller.saturation = known;
  p.controller.machine.r_r *= r_r;
  p.drive.magnetise_first = true;
  Foc::Parameters c;
  static_cast<EstimatingController<double>::Parameters&>(c) = p.controller;
  DriveRigOf<Foc> rig{p, c};
  rig.start();
  rig.run(0.3);
  rig.torque = torque;
  rig.run(0.3);
  Seen seen;
  seen.torque = rig.watch(0.1).mean_torque;
  seen.tripped = rig.telemetry.latched.any();
  return seen;
}

// Near standstill the torque follows from the current model, whose inductance is that of the flux.
TEST(SaturationRun, ADriveThatKnowsItMakesTheTorqueAtEverySpeed) {
  for (const double omega_m : {-400.0, -20.0, 0.0, 5.0, 50.0, 200.0}) {
    const double torque = std::abs(omega_m) > 100 ? 20.0 : 100.0;
    SCOPED_TRACE(testing::Message() << omega_m << " rad/s, " << torque << " N·m");
    const Seen seen = run(omega_m, torque, curve);
    EXPECT_FALSE(seen.tripped);
    EXPECT_NEAR(seen.torque, torque, 2.0);
  }
}

// What magnetising identifies is the machine, not its iron, also at standstill, where the voltage along the
// flux is all that shows, and with a knee that is off by 9 %.
TEST(SaturationRun, AWrongRotorResistanceIsFoundBesideTheKnownCurve) {
  for (const double r_r : {0.8, 1.25}) {
    for (const double knee : {1.0, 1.1, 1.2}) {
      for (const double omega_m : {0.0, 2.0, 20.0}) {
        SCOPED_TRACE(testing::Message() << r_r << ", " << knee << " Wb, " << omega_m << " rad/s");
        SaturationParameters<> known = curve;
        known.knee = knee;
        const Seen seen = run(omega_m, 60, known, r_r);
        EXPECT_FALSE(seen.tripped);
        EXPECT_NEAR(seen.torque, 60, 4.0);
      }
    }
  }
}

// In weakening the flux takes a fraction of the current that it takes at the reference: by the inductance
// there the link would have more voltage left than it has, and the torque that rises slowly would be a fault.
TEST(SaturationRun, AStepInFieldWeakeningIsNoFaultOfADriveThatKnowsIt) {
  // configs/machines/chapman_15hp.toml
  const TestMachine machine{
      "15 hp, two poles", {0.2, 0.12, 1.0876e-3, 1.0876e-3, 39.789e-3, 1, 0.05}, 294, 0.45025};
  const std::string knee = std::to_string(machine.psi);
  std::vector<std::string> set{
      "plant.integrator=fixed",
      "plant.sensors.current.noise_a=0.05",
      "plant.sensors.current.phase_a.gain_error=0.02",
      "plant.sensors.current.phase_a.offset_a=0.15",
      "plant.sensors.current.phase_b.gain_error=-0.02",
      "plant.sensors.current.phase_b.offset_a=-0.15",
  };
  for (const std::string side : {"plant.", "control.machine_estimate."}) {
    set.push_back(side + "saturation.knee_wb=" + knee);
    set.push_back(side + "saturation.machine_flux_wb=" + knee);
  }
  for (const std::string side : {"plant.", "drive."}) {
    set.push_back(side + "inverter.dead_time_us=3");
    set.push_back(side + "inverter.threshold_v=1.2");
  }
  for (const double speed : {1.2, 1.5, 2.0}) {
    for (const double torque : {0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << speed << ", " << torque);
      const MilResult result =
          run(machine, {.controller = "dtc",
                        .period_us = 125,
                        .omega_m = speed * 377,
                        .end_s = 1.5,
                        .torque = "[[0, 0], [1.2, " + std::to_string(26.3 * torque) + "]]",
                        .set = set});
      EXPECT_FALSE(result.faults.any());
    }
  }
}

}  // namespace
}  // namespace sextant
