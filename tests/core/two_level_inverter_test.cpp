#include "sextant/core/two_level_inverter.hpp"

#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240502;

template <class T>
class TwoLevelInverterOf : public testing::Test {
 protected:
  static constexpr T tolerance = T(1000) * T(20) * std::numeric_limits<T>::epsilon();
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TwoLevelInverterOf, Scalars);

TYPED_TEST(TwoLevelInverterOf, ActiveVectorsHaveTwoThirdsOfTheLinkEverySixtyDegrees) {
  using T = TypeParam;
  const T u_dc = T(530);
  for (unsigned n = 1; n <= 6; ++n) {
    const SpaceVector<T> u = stator_voltage(switch_states[n], u_dc);
    const T theta = T(n - 1) * std::numbers::pi_v<T> / T(3);
    const SpaceVector<T> expected = polar(T(2) / T(3) * u_dc, theta);
    EXPECT_NEAR(u.alpha, expected.alpha, this->tolerance) << "V" << n;
    EXPECT_NEAR(u.beta, expected.beta, this->tolerance) << "V" << n;
  }
}

TYPED_TEST(TwoLevelInverterOf, ZeroVectorsGiveNoVoltage) {
  using T = TypeParam;
  for (const unsigned n : {0U, 7U}) {
    const SpaceVector<T> u = stator_voltage(switch_states[n], T(530));
    EXPECT_NEAR(magnitude(u), T(0), this->tolerance) << "V" << n;
  }
}

// The inverter neither stores nor loses energy: u_dc i_dc = 3/2 u_s · i_s.
TYPED_TEST(TwoLevelInverterOf, DcPowerEqualsStatorPowerInEveryState) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<T> current{T(-100), T(100)};
  for (const SwitchState state : switch_states) {
    for (int i = 0; i < 200; ++i) {
      const SpaceVector<T> i_s{current(random), current(random)};
      const T dc = T(530) * dc_link_current(state, inverse_clarke(i_s));
      const T ac = T(1.5) * dot(stator_voltage(state, T(530)), i_s);
      EXPECT_NEAR(dc, ac, T(100) * this->tolerance);
    }
  }
}

TYPED_TEST(TwoLevelInverterOf, AnOpenLegFeedsTheLinkThroughItsUpperDiodeOnly) {
  using T = TypeParam;
  const ThreePhase<T> i{T(7), T(-4), T(-3)};
  EXPECT_EQ(dc_link_current(gates_off, i), T(-7)) << "b and c flow back through their upper diodes";
  EXPECT_EQ(dc_link_current(SwitchState{LegState::high, LegState::off, LegState::low}, i), T(3));
  EXPECT_EQ(dc_link_current(SwitchState{LegState::off, LegState::high, LegState::high}, i), T(-7));
}

TYPED_TEST(TwoLevelInverterOf, TheMeanOfAPatternWeighsItsSegments) {
  using T = TypeParam;
  const ThreePhase<T> driven{T(8), T(-4), T(-4)};
  const ThreePhase<T> open{T(2), T(-1), T(-1)};
  EXPECT_EQ(dc_link_current(GatePattern{}, driven, open), T(0));
  EXPECT_EQ(dc_link_current(GatePattern{switch_states[1], 100}, driven, open), T(8));
  EXPECT_EQ(dc_link_current(GatePattern{gates_off, 100}, driven, open), T(-2));
  // A period in which no measurement came: the state still in force, for no time.
  EXPECT_EQ(dc_link_current(GatePattern{switch_states[1], 0}, driven, open), T(8));
  GatePattern applied{switch_states[1], 300};
  applied.append({gates_off, 100});
  EXPECT_NEAR(dc_link_current(applied, driven, open), T(0.75) * T(8) - T(0.25) * T(2), this->tolerance);
}

TEST(SwitchState, TheEightStatesAreDrivenAndDiffer) {
  for (unsigned i = 0; i < switch_states.size(); ++i) {
    EXPECT_TRUE(is_driven(switch_states[i]));
    for (unsigned j = 0; j < i; ++j) EXPECT_NE(switch_states[i], switch_states[j]);
  }
}

TEST(SwitchState, IsNotDrivenWithAnyLegOff) {
  constexpr LegState any[] = {LegState::low, LegState::high, LegState::off};
  for (const LegState a : any) {
    for (const LegState b : any) {
      for (const LegState c : any) {
        const bool driven = a != LegState::off && b != LegState::off && c != LegState::off;
        EXPECT_EQ(is_driven({a, b, c}), driven);
      }
    }
  }
  EXPECT_FALSE(is_driven(gates_off));
}

TEST(SwitchState, NeighbouringActiveVectorsAreOneCommutationApart) {
  for (unsigned n = 1; n <= 6; ++n) {
    const SwitchState here = switch_states[n];
    EXPECT_EQ(commutations(here, here), 0);
    EXPECT_EQ(commutations(here, switch_states[n % 6 + 1]), 1);
    EXPECT_EQ(commutations(here, switch_states[(n + 2) % 6 + 1]), 3);
  }
}

}  // namespace
}  // namespace sextant
