#include "sextant/safety/phase_continuity.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double z = 2.0;  // reading of no current [A]

template <class T>
class PhaseContinuityOf : public testing::Test {
 protected:
  /// A period in which phase a reads i_a and ought to change by `predicted`, the others carry `peak`. [A]
  void step(double i_a, double peak, double predicted, double uncertainty = 0.0, double turn = 0.0) {
    const ThreePhase<T> v{T(predicted), T(-0.5 * predicted), T(-0.5 * predicted)};
    continuity.step({T(i_a), T(peak), T(-peak)}, {.v = v, .uncertainty = T(uncertainty), .turn = T(turn)});
  }
  PhaseContinuity<T> continuity{{.zero_current = T(z), .response = T(1)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PhaseContinuityOf, Scalars);

TYPED_TEST(PhaseContinuityOf, VoltageThatRaisesNoCurrentForTwentyPeriodsIsAnOpenPhase) {
  for (const double sign : {-1.0, 1.0}) {
    this->continuity.restart();
    for (int k = 1; k <= 19; ++k) {
      this->step(0.0, 10.0, sign);
      EXPECT_FALSE(this->continuity.is_open(0)) << k;
    }
    this->step(0.0, 10.0, sign);
    EXPECT_TRUE(this->continuity.is_open(0));
    EXPECT_FALSE(this->continuity.is_open(1)) << "carries current";
    EXPECT_FALSE(this->continuity.is_open(2));
    this->step(2.1, 10.0, sign);
    EXPECT_FALSE(this->continuity.is_open(0)) << "carries current now";
  }
}

TYPED_TEST(PhaseContinuityOf, ACurrentThatStaysNearZeroIsNone) {
  for (int k = 0; k < 2000; ++k) {  // from −2 to 2 A and back
    const double before = 1.99 * std::cos(0.01 * k);
    const double i = 1.99 * std::cos(0.01 * (k + 1));
    this->step(i, 10.0, k == 0 ? 50.0 : i - before);
    ASSERT_FALSE(this->continuity.is_open(0)) << "the change that led to zero does not count";
  }
}

TYPED_TEST(PhaseContinuityOf, APhaseThatAnswersByHalfMayBePredictedToChangeByTwiceAsMuch) {
  using T = TypeParam;
  for (const double predicted : {7.9, 8.1}) {
    this->continuity = PhaseContinuity<T>{{.zero_current = T(z), .response = T(0.5)}};
    for (int k = 0; k <= 20; ++k) this->step(0.0, 10.0, k == 1 ? predicted : 0.0);
    EXPECT_EQ(this->continuity.is_open(0), predicted > 8.0);
    this->continuity = PhaseContinuity<T>{{.zero_current = T(z), .response = T(0)}};
    for (int k = 0; k < 1000; ++k) this->step(0.0, 10.0, predicted);
    EXPECT_FALSE(this->continuity.is_open(0)) << "switched off";
  }
}

TYPED_TEST(PhaseContinuityOf, TheUncertaintyOfThePredictionIsAllowedForUntilTheFluxHasTurned) {
  // Of a peak of 20 A a healthy phase is below 2 A for 0.2 rad; allowed are 0.35 + 8 · 0.1 rad.
  for (const double turn : {0.0, 0.01, -0.01}) {
    this->continuity.restart();
    int open_at = 0;
    for (int k = 1; k <= 400 && open_at == 0; ++k) {
      this->step(0.0, 20.0, 0.3, 0.4, turn);
      if (this->continuity.is_open(0)) open_at = k;
    }
    EXPECT_NEAR(open_at, turn == 0.0 ? 0 : 117, 1);
  }
}

TYPED_TEST(PhaseContinuityOf, WhatHangsOnTheSignOfTheCurrentIsAllowedForAlsoWhenTheFluxHasTurned) {
  using T = TypeParam;
  for (const double by_sign : {0.28, 0.31}) {
    this->continuity.restart();
    int open_at = 0;
    for (int k = 1; k <= 400 && open_at == 0; ++k) {
      this->continuity.step({T(0), T(20), T(-20)},
                            {.v = {T(0.3), T(-0.15), T(-0.15)}, .by_sign = T(by_sign), .turn = T(0.1)});
      if (this->continuity.is_open(0)) open_at = k;
    }
    // 2z = 4 A by 0.02 A a period, or never.
    EXPECT_NEAR(open_at, by_sign < 0.3 ? 201 : 0, 1);
  }
}

TYPED_TEST(PhaseContinuityOf, NoTurnCountsWhileTheOthersCarryLittle) {
  for (int k = 0; k < 1000; ++k) this->step(0.0, 7.9, 0.3, 0.4, 0.05);
  EXPECT_FALSE(this->continuity.is_open(0));
  for (int k = 0; k < 30; ++k) this->step(0.0, 20.0, 0.3, 0.4, 0.05);
  EXPECT_TRUE(this->continuity.is_open(0));
}

// By a model whose EMF is wrong a current that passes through zero ought to change by ten times as much as it
// does: it moves, an open phase does not.
TYPED_TEST(PhaseContinuityOf, ACurrentThatPassesThroughZeroIsNoOpenPhase) {
  for (int k = 0; k <= 160; ++k) {
    this->step(-2.0 + k * 0.025, 10.0, 0.08);
    EXPECT_FALSE(this->continuity.is_open(0)) << k;
  }
  this->continuity.restart();
  for (int k = 0; k <= 160; ++k) this->step(0.5, 10.0, 0.08);
  EXPECT_TRUE(this->continuity.is_open(0)) << "readings that stand still";
}

}  // namespace
}  // namespace sextant
