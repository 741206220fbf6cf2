// The drive with its plant at the optima of the flux, with every control method.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/control/deadbeat_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

constexpr double psi_ref = 1.1;  // [Wb]

/// The drive as it is shipped, at a speed.
RigParameters shipped_at(double omega_m, FluxOptimum optimum) {
  RigParameters p = RigParameters::at_speed(omega_m);
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.drive.magnetise_first = true;
  p.drive.motor.optimal_flux.optimum = optimum;
  return p;
}

/// Means of the plant over 50 ms.
struct Means {
  double torque{};        ///< [N·m]
  double square{};        ///< |i_s|² [A²]
  double rotor_square{};  ///< |i_r|² [A²]
  double flux{};          ///< |ψ_s| [Wb]
};

template <class ControlMethod>
class OptimalFluxRun : public testing::Test {
 protected:
  using Rig = DriveRigOf<ControlMethod>;

  /// A rig whose torque is zero, with the flux of zero torque.
  static Rig at_rest(const RigParameters& p) {
    if constexpr (std::same_as<ControlMethod, DirectTorqueController<double>>) {
      return Rig{p};
    } else {
      return Rig{p, typename ControlMethod::Parameters{}};
    }
  }
  static void rest(Rig& rig) {
    rig.start();
    rig.run(2.0);
    ASSERT_EQ(rig.drive().state(), DriveState::torque);
  }
  static Means means(Rig& rig) {
    constexpr int periods = 2000;
    const InductionMachineParameters<> m;
    Means seen;
    for (int k = 0; k < periods; ++k) {
      rig.step();
      const auto i_s = rig.plant().i_s();
      const auto psi_s = rig.plant().psi_s();
      seen.torque += rig.plant().tau_e() / periods;
      seen.square += dot(i_s, i_s) / periods;
      const SpaceVector<double> i_r = (1.0 / m.l_m) * (psi_s - m.l_s() * i_s);
      seen.rotor_square += dot(i_r, i_r) / periods;
      seen.flux += magnitude(psi_s) / periods;
    }
    return seen;
  }
};
using ControlMethods = testing::Types<DirectTorqueController<double>, DeadbeatController<double>,
                                      FieldOrientedController<double>>;
TYPED_TEST_SUITE(OptimalFluxRun, ControlMethods);

TYPED_TEST(OptimalFluxRun, EachOptimumMakesTheTorqueWithTheCurrentAndTheLossOfItsEquations) {
  const InductionMachineParameters<> m;
  // Of 15 N·m: the square of the current is product · (ratio + 1/ratio), with ratio = i_d/i_q.
  const double product = 15.0 / (1.5 * m.pole_pairs * (m.l_s() - m.sigma_l_s()));
  const double loss_ratio = std::sqrt((m.r_s + m.k_r() * m.k_r() * m.r_r) / m.r_s);
  const double full_ratio = m.sigma_l_s() / m.l_s() / relative_slip(15.0, breakdown_torque(m, psi_ref));
  const struct {
    FluxOptimum optimum;
    double ratio;
  } rows[] = {{FluxOptimum::constant, full_ratio},
              {FluxOptimum::max_torque_per_ampere, 1.0},
              {FluxOptimum::min_loss, loss_ratio}};
  for (const double omega_m : {-80.0, 0.0, 50.0, 120.0}) {
    for (const auto& row : rows) {
      SCOPED_TRACE(std::to_string(int(row.optimum)) + " at " + std::to_string(omega_m) + " rad/s");
      auto rig = this->at_rest(shipped_at(omega_m, row.optimum));
      this->rest(rig);
      rig.torque = 15.0;
      rig.run(1.5);
      const Means seen = this->means(rig);
      EXPECT_NEAR(seen.torque, 15.0, 0.25);
      EXPECT_NEAR(std::sqrt(seen.square), std::sqrt(product * (row.ratio + 1.0 / row.ratio)), 0.3);
      const double loss = 1.5 * (m.r_s * seen.square + m.r_r * seen.rotor_square);
      const double rotor = m.k_r() * m.k_r() * product / row.ratio;
      EXPECT_NEAR(loss, 1.5 * (m.r_s * product * (row.ratio + 1.0 / row.ratio) + m.r_r * rotor), 0.06 * loss);
      const double i_d = std::sqrt(product * row.ratio);
      EXPECT_NEAR(seen.flux, std::hypot(m.l_s() * i_d, m.sigma_l_s() * i_d / row.ratio), 0.01);
      EXPECT_EQ(rig.drive().state(), DriveState::torque);
    }
  }
}

TYPED_TEST(OptimalFluxRun, ATorqueStepFromTheLeastFluxIsThereAtOnceAndTheFluxFollows) {
  for (const double omega_m : {-100.0, 0.0, 50.0, 100.0}) {
    for (const double torque : {60.0, -60.0}) {
      SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s");
      auto rig = this->at_rest(shipped_at(omega_m, FluxOptimum::max_torque_per_ampere));
      this->rest(rig);
      EXPECT_NEAR(this->means(rig).flux, 0.4 * psi_ref, 0.015);
      rig.torque = torque;
      const auto rise = rig.watch(0.01);
      ASSERT_TRUE(rise.reached_after_s.has_value());
      EXPECT_LT(*rise.reached_after_s, 3e-3);
      EXPECT_LT(rise.peak_current, 100.0);
      rig.run(0.09);
      const Means seen = this->means(rig);
      EXPECT_NEAR(seen.torque, torque, 0.5);
      EXPECT_NEAR(seen.flux, psi_ref, 0.02);
      EXPECT_EQ(rig.telemetry.latched, FaultSet{});
      EXPECT_EQ(rig.drive().state(), DriveState::torque);
    }
  }
}

TYPED_TEST(OptimalFluxRun, ATorqueBeyondThatOfTheLeastFluxIsDeratedUntilTheFluxHasRisen) {
  for (const double omega_m : {-100.0, 0.0, 100.0}) {
    SCOPED_TRACE(omega_m);
    auto rig = this->at_rest(shipped_at(omega_m, FluxOptimum::min_loss));
    this->rest(rig);
    EXPECT_EQ(rig.telemetry.torque_motoring, 150.0) << "what the drive delivers once the flux has risen";
    rig.torque = 150.0;
    double derated_s = 0.0;
    for (int k = 0; k < 4000; ++k) {
      rig.step();
      if (rig.drive().state() != DriveState::derated) continue;
      derated_s += rig.period_s;
      const Telemetry<double>& t = rig.telemetry;
      const double available = omega_m < 0.0 ? t.torque_regenerating : t.torque_motoring;
      EXPECT_LT(std::min(t.torque_reference, available), 150.0);
      EXPECT_EQ(t.derating_cause == DeratingCause::none, available == 150.0)
          << "on the reference's way to it";
    }
    EXPECT_GT(derated_s, 1e-3);
    EXPECT_LT(derated_s, 60e-3);
    const Means seen = this->means(rig);
    EXPECT_NEAR(seen.torque, 150.0, 2.0);
    EXPECT_NEAR(seen.flux, psi_ref, 0.02);
    EXPECT_EQ(rig.telemetry.latched, FaultSet{});
    EXPECT_EQ(rig.drive().state(), DriveState::torque);
  }
}

TYPED_TEST(OptimalFluxRun, BeyondBaseSpeedTheTorqueFollowsWithinTheFluxThatTheVoltageAllows) {
  for (const double omega_m : {200.0, -300.0}) {
    RigParameters p = shipped_at(omega_m, FluxOptimum::max_torque_per_ampere);
    const double sign = omega_m < 0.0 ? -1.0 : 1.0;
    p.load.imposed_speed = ProfileParameters{
        .shape = ProfileShape::linear, .points = {{0.0, sign * 100.0}, {1.0, sign * 100.0}, {1.3, omega_m}}};
    auto rig = this->at_rest(p);
    this->rest(rig);
    for (const double torque : {15.0, -15.0, 40.0, -40.0, 100.0, -100.0, 0.0, 15.0}) {
      SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s");
      rig.torque = torque;
      rig.run(0.15);
      const Means seen = this->means(rig);
      EXPECT_NEAR(seen.torque, rig.telemetry.torque_reference, 2.5);
      EXPECT_LT(seen.flux, 1.02 * 530.0 / std::sqrt(3.0) / (2.0 * std::abs(omega_m)) + 0.25);
      EXPECT_EQ(rig.telemetry.latched, FaultSet{});
    }
  }
}

TYPED_TEST(OptimalFluxRun, AMachineThatDiffersFromTheParametersDeliversItsTorque) {
  for (const double r_r : {0.5, 1.5}) {
    for (const double l_m : {0.7, 1.3}) {
      for (const FluxOptimum optimum : {FluxOptimum::max_torque_per_ampere, FluxOptimum::min_loss}) {
        SCOPED_TRACE("R_r times " + std::to_string(r_r) + ", L_m times " + std::to_string(l_m));
        RigParameters p = shipped_at(50.0, optimum);
        p.stage.plant.machine.r_r *= r_r;
        p.stage.plant.machine.l_m *= l_m;
        auto rig = this->at_rest(p);
        this->rest(rig);
        for (const double torque : {15.0, 60.0, -60.0, 5.0}) {
          SCOPED_TRACE(torque);
          rig.torque = torque;
          rig.run(0.3);
          EXPECT_NEAR(this->means(rig).torque, torque, std::max(2.0, 0.05 * std::abs(torque)));
          EXPECT_EQ(rig.telemetry.latched, FaultSet{});
        }
      }
    }
  }
}

}  // namespace
}  // namespace sextant
