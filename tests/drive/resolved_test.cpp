#include "sextant/drive/resolved.hpp"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class ResolvedOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ResolvedOf, Scalars);

TYPED_TEST(ResolvedOf, CountsATimeInWholeNanoseconds) {
  using T = TypeParam;
  EXPECT_EQ(whole_ns(T(0)), 0);
  EXPECT_EQ(whole_ns(T(0.25)), 250'000);
  EXPECT_EQ(whole_ns(T(1234.5)), 1'234'500'000);
  EXPECT_EQ(whole_ns(T(1e6)), 1'000'000'000'000);
  EXPECT_EQ(whole_ns(T(1e30)), 2'000'000'000'000'000);
  EXPECT_EQ(whole_ns(std::numeric_limits<T>::infinity()), 2'000'000'000'000'000);
}

TYPED_TEST(ResolvedOf, ATimeoutThatIsNoneIsRefused) {
  using T = TypeParam;
  for (const T time : {std::numeric_limits<T>::quiet_NaN(), T(0), T(-1), T(-1e30)}) {
    DriveSetup<T> setup;
    setup.magnetise_timeout_ms = time;
    EXPECT_EQ(whole_ns(time), 0) << time;
    EXPECT_STREQ(resolved(setup).validate(), "the time for magnetising must be above zero") << time;
  }
}

}  // namespace
}  // namespace sextant
