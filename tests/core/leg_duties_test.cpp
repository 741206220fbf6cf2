#include "sextant/core/leg_duties.hpp"

#include <cstddef>
#include <limits>

#include <gtest/gtest.h>

#include "sextant/core/two_level_inverter.hpp"

namespace sextant {
namespace {

template <class T>
class LegDuties : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LegDuties, Scalars);

template <class T>
void expect_duties(const GatePattern& pattern, T a, T b, T c) {
  const ThreePhase<T> d = leg_duties<T>(pattern);
  EXPECT_EQ(d.a, a);
  EXPECT_EQ(d.b, b);
  EXPECT_EQ(d.c, c);
}

// Paper, Table 3: the upper switches of each vector.
TYPED_TEST(LegDuties, OfOneVectorAreItsSwitches) {
  constexpr int upper[8][3]{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                            {0, 1, 1}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}};
  for (std::size_t n = 0; n < 8; ++n) {
    SCOPED_TRACE(n);
    expect_duties<TypeParam>({switch_states[n], 25'000}, TypeParam(upper[n][0]), TypeParam(upper[n][1]),
                             TypeParam(upper[n][2]));
  }
}

// V0, V1, V2, V7 and back, for 10, 20, 30 and 40 µs a half: leg a is high for 90 of 100, b for 70, c for 40.
TYPED_TEST(LegDuties, OfASymmetricPatternAreTheSharesOfItsTime) {
  constexpr std::size_t vectors[]{0, 1, 2, 7, 2, 1, 0};
  constexpr std::int32_t times_us[]{10, 20, 30, 80, 30, 20, 10};
  GatePattern pattern;
  for (std::size_t k = 0; k < 7; ++k) pattern.append({switch_states[vectors[k]], 1'000 * times_us[k]});
  const ThreePhase<TypeParam> d = leg_duties<TypeParam>(pattern);
  EXPECT_EQ(d.a, TypeParam(0.9));
  EXPECT_EQ(d.b, TypeParam(0.7));
  EXPECT_EQ(d.c, TypeParam(0.4));
  // The space vector of the duties is the mean voltage.
  constexpr auto u_dc = TypeParam(530);
  const SpaceVector<TypeParam> mean = (TypeParam(1) / TypeParam(200e-6)) * volt_seconds(pattern, u_dc);
  EXPECT_NEAR(u_dc * clarke(d).alpha, mean.alpha, 1e-4);
  EXPECT_NEAR(u_dc * clarke(d).beta, mean.beta, 1e-4);
}

TYPED_TEST(LegDuties, ALegThatIsOffCountsAsLow) {
  expect_duties<TypeParam>({gates_off, 25'000}, 0, 0, 0);
  GatePattern pattern{switch_states[7], 10'000};
  pattern.append({{LegState::high, LegState::off, LegState::low}, 30'000});
  EXPECT_FALSE(pattern.is_driven());
  expect_duties<TypeParam>(pattern, 1, TypeParam(0.25), TypeParam(0.25));
}

TYPED_TEST(LegDuties, WithoutTimeAreZero) {
  expect_duties<TypeParam>({}, 0, 0, 0);
  expect_duties<TypeParam>({switch_states[7], 0}, 0, 0, 0);
}

TYPED_TEST(LegDuties, OfTheLongestPatternDoNotOverflow) {
  GatePattern pattern;
  for (std::size_t k = 0; k < GatePattern::capacity; ++k)
    pattern.append({switch_states[k % 2 == 0 ? 7 : 1], std::numeric_limits<std::int32_t>::max()});
  expect_duties<TypeParam>(pattern, 1, TypeParam(0.5), TypeParam(0.5));
}

static_assert(leg_duties<float>({switch_states[2], 25'000}).b == 1.0F, "known when it is compiled");

}  // namespace
}  // namespace sextant
