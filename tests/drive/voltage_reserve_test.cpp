#include "sextant/drive/voltage_reserve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

template <class T>
class VoltageReserveOf : public testing::Test {
 protected:
  static constexpr T dt = T(25e-6);
  static constexpr T link = T(530);

  /// A period of a drive that turns forward; the torque lacks by `error`. [N·m]
  [[nodiscard]] TorqueTracking<T> period(T error) const {
    return {.reference = reference,
            .torque = reference - error,
            .omega_m = T(200),
            .u_dc = link,
            .flux_share = share,
            .makes_torque = true};
  }
  void run(T seconds, T error) {
    for (T t = T(0); t < seconds; t += dt) reserve.step(period(error), dt);
  }
  /// Half the torque that an active vector adds in one period of 25 µs: 3/2 p ψ/(σL_s) · 2/3 u_dc T.
  [[nodiscard]] T tolerance() const {
    const InductionMachineParameters<T> m{};
    return T(0.5) * share * T(1.5) * T(2) * T(1.1) / m.sigma_l_s() * T(2) / T(3) * link * dt;
  }
  T share{1};
  T reference{100};
  VoltageReserve<T> reserve{true, InductionMachineParameters<T>{}, T(1.1), 25'000};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(VoltageReserveOf, Scalars);

TYPED_TEST(VoltageReserveOf, AnErrorWithinTheToleranceHasNoEffect) {
  using T = TypeParam;
  EXPECT_NEAR(this->tolerance(), T(3.1), T(0.1));
  this->share = T(0.4);
  this->run(T(0.5), T(0.99) * this->tolerance());
  EXPECT_EQ(this->reserve.usable(), T(1));
  this->run(T(0.05), T(1.1) * this->tolerance());
  EXPECT_LT(this->reserve.usable(), T(1));
}

TYPED_TEST(VoltageReserveOf, AnErrorWithTheRotationHasNoEffect) {
  using T = TypeParam;
  this->run(T(0.1), T(-50));
  EXPECT_EQ(this->reserve.usable(), T(1));
}

// 15 % of 140 N·m need 15 % of the voltage's square.
TYPED_TEST(VoltageReserveOf, AnErrorOfFifteenPercentIsMetWithinTwentyMilliseconds) {
  using T = TypeParam;
  this->run(T(0.02), T(21));
  EXPECT_LT(this->reserve.usable(), T(0.85));
}

TYPED_TEST(VoltageReserveOf, ErrorsOfStepsHaveNoEffect) {
  using T = TypeParam;
  for (int k = 0; k < 20; ++k) {
    this->reference = -this->reference;
    this->run(T(4.5e-3), T(100));
  }
  EXPECT_EQ(this->reserve.usable(), T(1));
}

// Gates that go off every 4 ms, because periods are missed, take torque that the voltage would have made.
TYPED_TEST(VoltageReserveOf, WhatInterruptionsTakeHasNoEffect) {
  using T = TypeParam;
  for (int k = 0; k < 20; ++k) {
    TorqueTracking<T> gap = this->period(T(100));
    gap.interrupted = true;
    this->reserve.step(gap, this->dt);
    this->run(T(4e-3), T(50));
  }
  EXPECT_EQ(this->reserve.usable(), T(1));
}

// As at the voltage limit with a noisy speed: the limit, and the reference with it, moves by 1 N·m a period.
TYPED_TEST(VoltageReserveOf, AReferenceThatFollowsALimitIsNoStep) {
  using T = TypeParam;
  for (int k = 0; k < 800; ++k) {
    this->reference = T(100 + k % 2);
    TorqueTracking<T> now = this->period(T(21));
    now.limited = true;
    this->reserve.step(now, this->dt);
  }
  EXPECT_LT(this->reserve.usable(), T(0.9));
}

TYPED_TEST(VoltageReserveOf, TheTimeInWhichTheFluxIsOnItsWayIsLeftOut) {
  using T = TypeParam;
  TorqueTracking<T> now = this->period(T(100));
  now.slews = true;
  for (int k = 0; k < 4000; ++k) this->reserve.step(now, this->dt);
  EXPECT_EQ(this->reserve.usable(), T(1));
  for (int k = 0; k < 8000; ++k) {  // for half of the time
    now = this->period(T(21));
    now.slews = k % 80 < 40;
    this->reserve.step(now, this->dt);
  }
  EXPECT_LT(this->reserve.usable(), T(0.9));
}

TYPED_TEST(VoltageReserveOf, ReturnsSlowlyAndStaysWithinItsLimits) {
  using T = TypeParam;
  this->run(T(1), T(100));
  const T least = this->reserve.usable();
  EXPECT_GT(least, T(0.3));
  this->run(T(1), T(100));
  EXPECT_EQ(this->reserve.usable(), least);
  this->run(T(1), T(0));
  EXPECT_NEAR(this->reserve.usable() - least, T(0.05), T(2e-3));
  this->run(T(13), T(0));
  EXPECT_EQ(this->reserve.usable(), T(1));
}

TYPED_TEST(VoltageReserveOf, WhatIsNoNumberHasNoLastingEffect) {
  using T = TypeParam;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (int k = 0; k < 1000; ++k) this->reserve.step({nan, nan, nan, nan, nan, true}, this->dt);
  EXPECT_EQ(this->reserve.usable(), T(1));
  this->reserve.step({}, this->dt);
  this->run(T(0.02), T(21));
  EXPECT_LT(this->reserve.usable(), T(0.9));
}

/// Largest torque of the circuit at a stator flux, over the slips. [N·m]
double breakdown_by_circuit(const InductionMachineParameters<double>& m, double psi) {
  double most = 0.0;
  for (double slip = 0.0; slip < 200.0; slip += 0.05) {
    most = std::max(most, EquivalentCircuit::of_flux(m, 0.0, slip, psi).torque);
  }
  return most;
}

/// A machine with unlike factors under a constant error of its torque.
template <class T>
class VoltageReserveOfACircuit : public testing::Test {
 protected:
  static constexpr double psi = 0.7;
  static constexpr double dt = 50e-6;
  static constexpr double link = 400.0;

  void run(double seconds, double error, double slope = 0.0) {
    for (long left = std::lround(seconds / dt); left > 0; --left) {
      reference += slope * dt;
      reserve.step({.reference = T(reference),
                    .torque = T(reference - error),
                    .omega_m = T(100),
                    .u_dc = T(link),
                    .makes_torque = true},
                   T(dt));
    }
  }

  InductionMachineParameters<double> machine{unlike_machine()};
  double breakdown{breakdown_by_circuit(machine, psi)};
  double reference{10.0};
  VoltageReserve<T> reserve{true, in_scalar<T>(machine), T(psi), 50'000};
};
TYPED_TEST_SUITE(VoltageReserveOfACircuit, Scalars);

// After 5 ms the mean of the error goes to it with 2 ms, and the share falls with 700/T_b of what is beyond
// half of the torque that the largest vector, 2/3 u_dc across the flux, adds in a period: its integral is
// written out here.
TYPED_TEST(VoltageReserveOfACircuit, FallsByTheIntegralOfTheMeanErrorBeyondItsTolerance) {
  const auto& m = this->machine;
  const double sigma_l_s = m.l_ls + m.l_m - m.l_m * m.l_m / (m.l_lr + m.l_m);
  const double tolerance =
      0.5 * 1.5 * m.pole_pairs * this->psi * (2.0 / 3.0 * this->link * this->dt) / sigma_l_s;
  const double error = 6.0 * tolerance;
  const double tau = 2e-3;
  const double t = 3e-3;
  const double begin = -tau * std::log(1.0 - tolerance / error);
  const double beyond =
      (error - tolerance) * (t - begin) - error * tau * (std::exp(-begin / tau) - std::exp(-t / tau));
  this->run(5e-3 + t, error);
  const double step = 700.0 / this->breakdown * (error - tolerance) * this->dt;
  const double fall = 700.0 / this->breakdown * beyond;
  ASSERT_GT(fall, 10.0 * step);
  EXPECT_NEAR(double(this->reserve.usable()), 1.0 - fall, 2.0 * step);
}

TYPED_TEST(VoltageReserveOfACircuit, AReferenceThatMovesByTheBreakdownTorqueInFortyMillisecondsSteps) {
  const double rate = this->breakdown / 0.04;
  this->run(0.01, 20.0, 1.05 * rate);
  EXPECT_EQ(this->reserve.usable(), TypeParam(1));
  this->run(0.01, 20.0, 0.95 * rate);
  EXPECT_LT(this->reserve.usable(), TypeParam(1));
}

TYPED_TEST(VoltageReserveOf, AMeanTorqueThatIsNotHeldMayBeOffTwiceAsFar) {
  using T = TypeParam;
  this->reserve = VoltageReserve<T>{false, InductionMachineParameters<T>{}, T(1.1), 25'000};
  this->run(T(0.5), T(1.98) * this->tolerance());
  EXPECT_EQ(this->reserve.usable(), T(1));
  this->run(T(0.05), T(2.2) * this->tolerance());
  EXPECT_LT(this->reserve.usable(), T(1));
}

}  // namespace
}  // namespace sextant
