// Field-oriented control closed around the reference machine, which is integrated within each pattern.
#include "sextant/control/field_oriented_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "control/controlled_machine.hpp"

namespace sextant {
namespace {

constexpr double psi_ref = 1.1;

template <class T>
using Loop = test::ControlledMachine<T, FieldOrientedController<T>>;

template <class T>
typename FieldOrientedController<T>::Parameters parameters(int delay = 1) {
  typename FieldOrientedController<T>::Parameters p;
  p.actuation_delay_periods = delay;
  p.magnetiser = {.current_limit = T(40), .hand_over_current = T(30)};
  return p;
}

template <class T>
class FieldOrientedControllerOf : public testing::Test {
 protected:
  struct Step {
    double settled_ms;  ///< the torque is within 5 % of the step from then on
    double overshoot;   ///< by the step [-]
  };

  /// From 0 to `torque` on a machine that turns and has its flux.
  static Step step(Loop<T>& loop, double torque) {
    loop.machine.omega_m = 50;
    loop.magnetise();
    loop.run(ControlMode::torque, 0, 200);
    Step s{0, 0};
    for (int k = 1; k <= 400; ++k) {
      const double share = loop.step(ControlMode::torque, torque) / torque;
      if (std::abs(share - 1) > 0.05) s.settled_ms = k * 0.025;
      s.overshoot = std::max(s.overshoot, share - 1);
    }
    return s;
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FieldOrientedControllerOf, Scalars);

TYPED_TEST(FieldOrientedControllerOf, IsIndirectWithTheCurrentModel) {
  auto p = parameters<TypeParam>();
  p.flux_estimator = FluxEstimatorKind::current_model;
  Loop<TypeParam> loop{p};
  loop.machine.omega_m = 75;
  loop.magnetise();
  loop.run(ControlMode::torque, 60, 200);
  const auto r = loop.ripple(60, 20, psi_ref);
  EXPECT_LE(r.worst, 0.40);
  EXPECT_LE(std::abs(r.bias), 0.04);
}

// 8000 rad/s: 5 % remain after 0.37 ms, the period of delay apart; and 60 N·m against the EMF take 0.2 ms
// more, 19 A at 4.7 mH and some 200 V.
TYPED_TEST(FieldOrientedControllerOf, AStepOfTorqueTakesTheTimeOfTheBandwidthAndHasNoOvershoot) {
  for (const double torque : {60.0, -60.0}) {
    Loop<TypeParam> loop{parameters<TypeParam>()};
    const auto s = this->step(loop, torque);
    EXPECT_GE(s.settled_ms, 0.35);
    EXPECT_LE(s.settled_ms, 0.65);
    EXPECT_LE(s.overshoot, 0.002);
  }
}

// e^{−α t_period} of it remains, also where the frame turns by 2 % of a radian in a period.
TYPED_TEST(FieldOrientedControllerOf, TheErrorFallsInEveryPeriodAsTheBandwidthSays) {
  struct Case {
    double omega_m;
    double flux_share;
  };
  for (const Case c : {Case{50, 1}, Case{400, 0.15}, Case{-400, 0.15}}) {
    Loop<TypeParam> loop{parameters<TypeParam>(0)};
    loop.machine.omega_m = c.omega_m;
    loop.flux_share = c.flux_share;
    loop.magnetise();
    loop.run(ControlMode::torque, 0, 200);
    double before = 1;
    for (int k = 0; k < 12; ++k) {
      const double error = 1 - loop.step(ControlMode::torque, 1);
      EXPECT_NEAR(error / before, std::exp(-0.2), 0.01) << c.omega_m << " rad/s, period " << k;
      before = error;
    }
  }
}

// 200 µs at 350 rad/s: the frame turns by 8° in a period.
TYPED_TEST(FieldOrientedControllerOf, AStepAcrossTheFluxLeavesTheCurrentAlongItAlone) {
  using T = TypeParam;
  auto p = parameters<T>(0);
  p.period_ns = 200'000;
  p.bandwidth = T(1000);
  p.flux_estimator = FluxEstimatorKind::current_model;
  Loop<T> loop{p};
  loop.machine.omega_m = 350;
  loop.flux_share = 0.3;
  loop.run(ControlMode::magnetise, 0, 100);
  loop.run(ControlMode::torque, 0, 50);
  const auto i_dq = [&loop] {
    return loop.machine.i_s() * std::conj(loop.machine.psi_r) / std::abs(loop.machine.psi_r);
  };
  const double before = i_dq().real();
  for (int k = 0; k < 30; ++k) {
    loop.step(ControlMode::torque, 5);
    // 5.3 A across the flux take 0.2 A of those along it: |ψ_s| is to stay.
    EXPECT_NEAR(i_dq().real() - before, -0.1, 0.13) << k;
  }
  EXPECT_NEAR(i_dq().imag(), 5.3, 0.1);
}

TYPED_TEST(FieldOrientedControllerOf, TheVoltageGoesOnFromThatOfMagnetising) {
  for (const double omega_m : {0.0, 110.0, -110.0}) {
    Loop<TypeParam> loop{parameters<TypeParam>()};
    loop.machine.omega_m = omega_m;
    loop.run(ControlMode::magnetise, 0, 400);
    for (int k = 0; k < 200; ++k) EXPECT_NEAR(loop.step(ControlMode::torque, 0), 0, 0.1) << omega_m;
  }
}

TYPED_TEST(FieldOrientedControllerOf, TheLargestBandwidthLeavesRoomForAnotherLeakage) {
  using T = TypeParam;
  for (const double factor : {0.5, 2.0}) {
    auto p = parameters<T>();
    p.bandwidth = T(20'000);
    InductionMachineParameters<double> real;
    real.l_ls *= factor;
    real.l_lr *= factor;
    Loop<T> loop{p, real};
    const auto s = this->step(loop, -60);
    EXPECT_LE(s.settled_ms, 0.7) << factor;
    EXPECT_LE(s.overshoot, 0.12) << factor;
  }
}

TYPED_TEST(FieldOrientedControllerOf, RefusesParametersThatCannotWork) {
  using T = TypeParam;
  using Parameters = typename FieldOrientedController<T>::Parameters;
  const auto refused = [](auto change) {
    Parameters p = parameters<T>();
    change(p);
    return p.validate() != nullptr;
  };
  EXPECT_FALSE(refused([](Parameters&) {}));
  EXPECT_FALSE(refused([](Parameters& p) { p.bandwidth = T(20'000); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.bandwidth = T(20'100); })) << "0.5 / 25 µs";
  EXPECT_TRUE(refused([](Parameters& p) { p.period_ns = 100'000; })) << "with the bandwidth of 25 µs";
  EXPECT_TRUE(refused([](Parameters& p) { p.bandwidth = T(0); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.bandwidth = std::numeric_limits<T>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.bandwidth = std::numeric_limits<T>::infinity(); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.current_limit = T(12); })) << "12.8 A magnetise the machine";
}

}  // namespace
}  // namespace sextant
