#include "sextant/control/flux_comparator.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240504;

template <class T>
class FluxComparatorOf : public testing::Test {
 protected:
  static constexpr T band = T(0.01);
  [[nodiscard]] static T above(T x) { return std::nextafter(x, std::numeric_limits<T>::infinity()); }
  [[nodiscard]] static T below(T x) { return std::nextafter(x, -std::numeric_limits<T>::infinity()); }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FluxComparatorOf, Scalars);

TYPED_TEST(FluxComparatorOf, RaisesUntilBelowMinusTheBandAndLowersUntilAboveIt) {
  FluxComparator<TypeParam> comparator{{this->band}};
  EXPECT_TRUE(comparator.output());
  EXPECT_TRUE(comparator.step(-this->band));
  EXPECT_FALSE(comparator.step(this->below(-this->band)));
  EXPECT_FALSE(comparator.step(this->band));
  EXPECT_TRUE(comparator.step(this->above(this->band)));
}

TYPED_TEST(FluxComparatorOf, FollowsItsDefinitionOverARandomErrorWalk) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::normal_distribution<T> change{T(0), T(0.006)};
  FluxComparator<T> comparator{{this->band}};
  bool raise = true;
  T error{};
  for (int i = 0; i < 20'000; ++i) {
    error = T(0.95) * error + change(random);
    if (error > this->band) raise = true;
    if (error < -this->band) raise = false;
    ASSERT_EQ(comparator.step(error), raise) << "sample " << i << ", error " << error;
  }
}

TYPED_TEST(FluxComparatorOf, ItsOneThresholdTellsWhereAStepSwitches) {
  using T = TypeParam;
  for (const bool raise : {false, true}) {
    FluxComparator<T> comparator{{this->band}};
    comparator.step(raise ? T(1) : T(-1));
    const Thresholds<T> thresholds = comparator.thresholds();
    const bool rising = std::isfinite(thresholds.above);
    ASSERT_NE(rising, std::isfinite(thresholds.below));
    const T level = rising ? thresholds.above : thresholds.below;
    auto stepped = comparator;
    EXPECT_EQ(stepped.step(level), raise);
    EXPECT_EQ(stepped.step(rising ? this->above(level) : this->below(level)), !raise);
    comparator.on_crossing(rising ? 0 : 1);
    EXPECT_EQ(comparator.output(), !raise);
  }
}

TYPED_TEST(FluxComparatorOf, RaisesAfterAResetAndRefusesABandThatIsNone) {
  using T = TypeParam;
  FluxComparator<T> comparator{{this->band}};
  comparator.step(T(-1));
  comparator.reset();
  EXPECT_TRUE(comparator.output());
  using Parameters = typename FluxComparator<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    EXPECT_NE(Parameters{bad}.validate(), nullptr);
  }
}

}  // namespace
}  // namespace sextant
