#include "sextant/safety/setpoint_ramp.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class SetpointRampOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SetpointRampOf, Scalars);

TYPED_TEST(SetpointRampOf, ApproachesATargetFromEitherSideAndEndsOnItExactly) {
  using T = TypeParam;
  SetpointRamp<T> ramp;
  EXPECT_EQ(ramp.step(T(1.1), T(0.5)), T(0.5));
  EXPECT_EQ(ramp.step(T(1.1), T(0.5)), T(1));
  EXPECT_EQ(ramp.step(T(1.1), T(0.5)), T(1.1));
  EXPECT_EQ(ramp.step(T(-2), T(1.1)), T(0));
  EXPECT_EQ(ramp.step(T(-2), T(4)), T(-2));
}

TYPED_TEST(SetpointRampOf, StartsAtZeroAndReturnsThereOnReset) {
  using T = TypeParam;
  SetpointRamp<T> ramp;
  EXPECT_EQ(ramp.value(), T(0));
  ramp.step(T(7), T(1));
  ramp.reset();
  EXPECT_EQ(ramp.value(), T(0));
}

}  // namespace
}  // namespace sextant
