#include "sextant/safety/applied_volt_seconds.hpp"

#include <gtest/gtest.h>

#include "sextant/core/two_level_inverter.hpp"

namespace sextant {
namespace {

template <class T>
class AppliedVoltSecondsOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(AppliedVoltSecondsOf, Scalars);

TYPED_TEST(AppliedVoltSecondsOf, OfEachStateAreTheSpaceVectorsVoltageTimesItsDuration) {
  using T = TypeParam;
  for (const SwitchState state : switch_states) {
    const ThreePhase<T> applied = applied_volt_seconds(GatePattern{state, 25'000}, T(530));
    const SpaceVector<T> found = clarke(applied);
    const SpaceVector<T> expected = T(25e-6) * stator_voltage(state, T(530));
    EXPECT_NEAR(found.alpha, expected.alpha, T(1e-8));
    EXPECT_NEAR(found.beta, expected.beta, T(1e-8));
    EXPECT_NEAR(applied.a + applied.b + applied.c, T(0), T(1e-8));
  }
}

TYPED_TEST(AppliedVoltSecondsOf, SegmentsAddUp) {
  using T = TypeParam;
  GatePattern pattern;
  pattern.append({switch_states[1], 10'000});
  pattern.append({switch_states[4], 10'000});  // the opposite vector
  pattern.append({switch_states[7], 5'000});
  const ThreePhase<T> applied = applied_volt_seconds(pattern, T(530));
  EXPECT_NEAR(applied.a, T(0), T(1e-9));
  EXPECT_NEAR(applied.b, T(0), T(1e-9));
}

}  // namespace
}  // namespace sextant
