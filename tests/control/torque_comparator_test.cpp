#include "sextant/control/torque_comparator.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240503;

template <class T>
class TorqueComparatorOf : public testing::Test {
 protected:
  static constexpr T upper = T(1.25);
  static constexpr T lower = T(0.5);

  [[nodiscard]] static TorqueComparator<T> make(ComparatorReading reading) {
    return TorqueComparator<T>{{upper, lower, reading}};
  }
  /// A comparator of which the output has been driven to `output`.
  [[nodiscard]] static TorqueComparator<T> make(ComparatorReading reading, int output) {
    TorqueComparator<T> comparator = make(reading);
    comparator.step(T(output) * T(10));
    EXPECT_EQ(comparator.output(), output);
    return comparator;
  }
  [[nodiscard]] static T above(T x) { return std::nextafter(x, std::numeric_limits<T>::infinity()); }
  [[nodiscard]] static T below(T x) { return std::nextafter(x, -std::numeric_limits<T>::infinity()); }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueComparatorOf, Scalars);

TYPED_TEST(TorqueComparatorOf, SwitchesOnStrictlyBeyondEachBandInBothReadings) {
  for (const auto reading : {ComparatorReading::relay, ComparatorReading::memoryless}) {
    auto comparator = this->make(reading);
    EXPECT_EQ(comparator.step(this->upper), 0);
    EXPECT_EQ(comparator.step(this->above(this->upper)), 1);
    comparator.reset();
    EXPECT_EQ(comparator.step(-this->lower), 0);
    EXPECT_EQ(comparator.step(this->below(-this->lower)), -1);
  }
}

TYPED_TEST(TorqueComparatorOf, ARelaySwitchesOffStrictlyBeyondZeroError) {
  using T = TypeParam;
  auto comparator = this->make(ComparatorReading::relay, 1);
  EXPECT_EQ(comparator.step(this->upper / T(2)), 1);
  EXPECT_EQ(comparator.step(T(0)), 1);
  EXPECT_EQ(comparator.step(this->below(T(0))), 0);
  comparator = this->make(ComparatorReading::relay, -1);
  EXPECT_EQ(comparator.step(-this->lower / T(2)), -1);
  EXPECT_EQ(comparator.step(T(0)), -1);
  EXPECT_EQ(comparator.step(this->above(T(0))), 0);
}

TYPED_TEST(TorqueComparatorOf, WithoutMemoryItSwitchesOffAtTheBand) {
  auto comparator = this->make(ComparatorReading::memoryless, 1);
  EXPECT_EQ(comparator.step(this->upper), 1);
  EXPECT_EQ(comparator.step(this->below(this->upper)), 0);
  comparator = this->make(ComparatorReading::memoryless, -1);
  EXPECT_EQ(comparator.step(-this->lower), -1);
  EXPECT_EQ(comparator.step(this->above(-this->lower)), 0);
}

TYPED_TEST(TorqueComparatorOf, AJumpAcrossTheWholeBandReversesInOneSample) {
  using T = TypeParam;
  for (const auto reading : {ComparatorReading::relay, ComparatorReading::memoryless}) {
    auto comparator = this->make(reading, 1);
    EXPECT_EQ(comparator.step(T(-10)), -1);
    EXPECT_EQ(comparator.step(T(10)), 1);
  }
}

TYPED_TEST(TorqueComparatorOf, FollowsItsDefinitionOverRandomErrorWalks) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::normal_distribution<T> change{T(0), T(0.6)};
  auto relay = this->make(ComparatorReading::relay);
  auto memoryless = this->make(ComparatorReading::memoryless);
  bool upper_on = false;
  bool lower_on = false;
  T error{};
  for (int i = 0; i < 20'000; ++i) {
    error = T(0.95) * error + change(random);
    if (error > this->upper) upper_on = true;
    if (error < T(0)) upper_on = false;
    if (error < -this->lower) lower_on = true;
    if (error > T(0)) lower_on = false;
    ASSERT_EQ(relay.step(error), int(upper_on) - int(lower_on)) << "sample " << i << ", error " << error;
    const int expected = int(error > this->upper) - int(error < -this->lower);
    ASSERT_EQ(memoryless.step(error), expected) << "sample " << i << ", error " << error;
  }
}

TYPED_TEST(TorqueComparatorOf, ThresholdsTellWhereAStepSwitchesAndWhereTo) {
  using T = TypeParam;
  for (const auto reading : {ComparatorReading::relay, ComparatorReading::memoryless}) {
    for (const int output : {-1, 0, 1}) {
      const auto comparator = this->make(reading, output);
      const Thresholds<T> thresholds = comparator.thresholds();
      const std::array<T, 2> levels{thresholds.above, thresholds.below};
      EXPECT_EQ(std::isfinite(levels[0]) + std::isfinite(levels[1]), output == 0 ? 2 : 1);
      for (int i = 0; i < 2; ++i) {
        const T level = levels[unsigned(i)];
        if (!std::isfinite(level)) continue;
        const bool rising = i == 0;
        auto crossed = comparator;
        crossed.on_crossing(i);
        auto stepped = comparator;
        EXPECT_EQ(stepped.step(level), output);
        EXPECT_EQ(stepped.step(rising ? this->below(level) : this->above(level)), output);
        EXPECT_EQ(stepped.step(rising ? this->above(level) : this->below(level)), crossed.output());
        EXPECT_NE(crossed.output(), output);
      }
    }
  }
}

TYPED_TEST(TorqueComparatorOf, HoldsItsOutputOnANaN) {
  using T = TypeParam;
  for (const int output : {-1, 0, 1}) {
    auto comparator = this->make(ComparatorReading::relay, output);
    EXPECT_EQ(comparator.step(std::numeric_limits<T>::quiet_NaN()), output);
  }
}

TYPED_TEST(TorqueComparatorOf, RefusesBandsThatAreNoBands) {
  using T = TypeParam;
  using Parameters = typename TorqueComparator<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.upper_band = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.lower_band = bad}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
