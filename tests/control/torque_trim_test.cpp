#include "sextant/control/torque_trim.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"

namespace sextant {
namespace {

constexpr double period_s = 25e-6;
constexpr double psi_ref = 1.1;
constexpr double u_dc = 530;

template <class T>
class TorqueTrimOf : public testing::Test {
 protected:
  static TorqueTrim<T> trim_of(double time_constant) {
    return TorqueTrim<T>{{.time_constant = T(time_constant)},
                         test::converted<T>(InductionMachineParameters<double>{}),
                         T(period_s)};
  }
  T step(double reference, double torque, double link = u_dc) {
    return trim.step(T(reference), T(torque), T(psi_ref), T(link), false);
  }
  /// Periods in which the torque swings about the trimmed reference, off it by `bias` in the mean.
  void swing(int periods, double reference, double bias, double amplitude = 3) {
    for (int k = 0; k < periods; ++k) {
      step(reference, reference + double(trim.value()) + bias + (k % 2 == 0 ? amplitude : -amplitude));
    }
  }

  TorqueTrim<T> trim = trim_of(0.01);
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueTrimOf, Scalars);

// dx/dt = −(bias + x)/τ, so that x = −bias (1 − e^{−t/τ}).
TYPED_TEST(TorqueTrimOf, TakesAnOffsetAwayWithItsTimeConstant) {
  for (const double bias : {-2.0, 1.5}) {
    for (const double torque : {0.0, 40.0, -40.0}) {
      this->trim.reset();
      this->swing(2, torque, bias);
      for (const double times_tau : {0.5, 1.0, 3.0}) {
        this->trim.reset();
        this->swing(int(times_tau * 0.01 / period_s), torque, bias);
        EXPECT_NEAR(double(this->trim.value()), -bias * (1 - std::exp(-times_tau)), 0.01 * std::abs(bias));
      }
      this->swing(5000, torque, bias);
      EXPECT_NEAR(double(this->trim.value()), -bias, 0.01);
    }
  }
}

TYPED_TEST(TorqueTrimOf, IsLimitedToWhatOneVectorChangesOfTheTorqueInAPeriod) {
  // Flux without stator current, ψ_r = L_r/L_m ψ_s, and 25 µs of the vector across it.
  test::ReferenceMachine machine;
  machine.psi_s = psi_ref * std::polar(1.0, std::acos(-1.0) / 2);
  machine.psi_r = machine.psi_s * (0.0855740565427 / 0.083174);
  machine.apply(GatePattern{switch_states[4], 25'000});  // −α, which turns β forward
  const double change = machine.torque();
  EXPECT_GT(change, 5);
  for (const double sign : {1.0, -1.0}) {
    this->trim.reset();
    // Crosses the reference, but is off it by 0.9 of the limit more than the trim can take away.
    this->swing(20'000, 15, -sign * 1.9 * change, 1.95 * change);
    EXPECT_NEAR(double(this->trim.value()), sign * change, 0.02 * change);
  }
}

TYPED_TEST(TorqueTrimOf, TheLimitGoesWithTheLinkVoltageAndAnAbsentLinkLeavesNone) {
  this->swing(20'000, 15, -8, 9);
  const double full = double(this->trim.value());
  this->step(15, 15, 0.5 * u_dc);
  EXPECT_NEAR(double(this->trim.value()), 0.5 * full, 0.01 * full);
  for (const double link : {0.0, -10.0}) {
    this->step(15, 15, link);
    EXPECT_LE(std::abs(double(this->trim.value())), 0.2);
  }
}

// ΔT goes with ψ_ref u_dc: half of each leaves a quarter of it, and the same share of a quarter.
TYPED_TEST(TorqueTrimOf, KeepsItsShareOfWhatAVectorChangesWhenFluxOrLinkFall) {
  using T = TypeParam;
  this->swing(4000, 15, -2);
  const double before = double(this->trim.value());
  ASSERT_NEAR(before, 2, 0.05);
  this->trim.step(T(15), T(15), T(0.5 * psi_ref), T(0.5 * u_dc), false);
  EXPECT_NEAR(double(this->trim.value()), 0.25 * before, 0.02);
  this->step(15, 15);
  EXPECT_NEAR(double(this->trim.value()), before, 0.05);
}

TYPED_TEST(TorqueTrimOf, HoldsItsValueAfterAStepUntilTheTorqueHasCrossedTheReference) {
  this->swing(4000, 15, -2);
  const double before = double(this->trim.value());
  ASSERT_NEAR(before, 2, 0.05);
  for (int k = 0; k < 200; ++k) this->step(60, 15 + 0.225 * k);  // to the reference from below
  EXPECT_EQ(double(this->trim.value()), before);
  for (int k = 0; k < 2000; ++k) this->step(60, 60);  // short of the trimmed reference: the voltage is out
  EXPECT_EQ(double(this->trim.value()), before);
  this->step(60, 60 + before + 1);
  EXPECT_LT(double(this->trim.value()), before);
}

// A torque between both references is where the trim alone has led it: it gives way, though the torque never
// crosses the trimmed reference, as where the vectors lock to the turn of the flux.
TYPED_TEST(TorqueTrimOf, GivesWayToATorqueThatStandsBetweenBothReferences) {
  for (const double sign : {1.0, -1.0}) {
    this->trim.reset();
    this->swing(20'000, 15, -sign * 8, 9);
    const double wound = double(this->trim.value());
    for (int k = 0; k < 10; ++k) this->step(15, 15 - sign * 60);
    EXPECT_EQ(double(this->trim.value()), wound);
    for (int k = 0; k < 400; ++k) this->step(15, 15 + 0.6 * wound);
    // dx/dt = −0.6 x_0/τ for one τ.
    EXPECT_NEAR(double(this->trim.value()), 0.4 * wound, 0.02 * std::abs(wound));
  }
}

TYPED_TEST(TorqueTrimOf, StartsOnlyWhenTheTorqueHasCrossedTheReference) {
  for (int k = 0; k < 2000; ++k) this->step(5, 2);
  EXPECT_EQ(double(this->trim.value()), 0);
  for (int k = 0; k < 2000; ++k) this->step(0, 0);
  EXPECT_EQ(double(this->trim.value()), 0);
  this->swing(400, 5, 1);
  EXPECT_LT(double(this->trim.value()), -0.3);
}

// A method that takes zero vectors, because no active one leads nearer, never crosses the reference.
TYPED_TEST(TorqueTrimOf, StartsAlsoWhereTheMethodRestsShortOfTheReference) {
  for (int k = 0; k < 100; ++k)
    this->trim.step(TypeParam(5), TypeParam(2), TypeParam(psi_ref), TypeParam(u_dc), true);
  EXPECT_GT(double(this->trim.value()), 0.5);
}

TYPED_TEST(TorqueTrimOf, AStepOfTheReferencePassesAtOnce) {
  this->swing(4000, 15, -2);
  const double trimmed = double(this->step(15, 15));
  const double value = double(this->trim.value());
  EXPECT_NEAR(trimmed, 15 + value, 1e-5);
  EXPECT_NEAR(double(this->step(-60, 15)), -60 + value, 1e-4);
}

TYPED_TEST(TorqueTrimOf, WithoutTimeConstantGivesTheReferenceItself) {
  using T = TypeParam;
  this->trim = this->trim_of(0);
  for (int k = 0; k < 1000; ++k) {
    const double torque = 12 + (k % 2 == 0 ? 5 : -1);
    ASSERT_EQ(this->step(14.75, torque), T(14.75));
  }
}

// A time constant below the period acts within one: the gain stays below 1.
TYPED_TEST(TorqueTrimOf, IsStableWithAnyTimeConstant) {
  this->trim = this->trim_of(1e-6);
  this->swing(200, 15, -2);
  EXPECT_NEAR(double(this->trim.value()), 2, 3.1);
}

TYPED_TEST(TorqueTrimOf, AValueThatIsNoNumberLeavesNoTrace) {
  using T = TypeParam;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  this->swing(4000, 15, -2);
  const T before = this->trim.value();
  this->step(15, nan);
  this->step(nan, 15);
  this->step(15, std::numeric_limits<double>::infinity());
  EXPECT_EQ(this->trim.value(), before);
  this->swing(4000, 15, -1);
  EXPECT_NEAR(double(this->trim.value()), 1, 0.05);
}

TYPED_TEST(TorqueTrimOf, IsZeroAfterAReset) {
  this->swing(4000, 15, -2);
  this->trim.reset();
  EXPECT_EQ(double(this->trim.value()), 0);
  this->step(15, 16);
  EXPECT_EQ(double(this->trim.value()), 0);
}

TYPED_TEST(TorqueTrimOf, RefusesATimeConstantThatIsNone) {
  using T = TypeParam;
  using Parameters = typename TorqueTrim<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  EXPECT_EQ(Parameters{.time_constant = T(0)}.validate(), nullptr);
  EXPECT_NE(Parameters{.time_constant = T(-1e-3)}.validate(), nullptr);
  EXPECT_NE(Parameters{.time_constant = std::numeric_limits<T>::infinity()}.validate(), nullptr);
  EXPECT_NE(Parameters{.time_constant = std::numeric_limits<T>::quiet_NaN()}.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
