#include "sextant/control/current_staircase.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class CurrentStaircaseOf : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(CurrentStaircaseOf, Scalars);

template <class T>
typename CurrentStaircase<T>::Parameters short_stair() {
  return {.highest = T(20), .levels = 4, .slope = T(3), .settle_periods = 5, .hold_periods = 7};
}

/// The current of each level that is held, once a level; every hold has the periods that it is to have.
template <class T>
std::vector<T> held_levels(CurrentStaircase<T>& stair, int hold_periods) {
  std::vector<T> levels;
  int held = 0;
  for (int k = 0; k < 10'000 && !stair.is_done(); ++k) {
    const T current = stair.step();
    held = stair.holds() ? held + 1 : 0;
    if (!stair.ends_level()) continue;
    EXPECT_EQ(held, hold_periods);
    EXPECT_EQ(stair.index(), int(levels.size()));
    levels.push_back(current);
    held = 0;
  }
  return levels;
}

TYPED_TEST(CurrentStaircaseOf, FallsFromTheHighestLevelToItsOpposite) {
  using T = TypeParam;
  CurrentStaircase<T> stair{short_stair<T>()};
  const std::vector<T> levels = held_levels(stair, 7);
  const double expected[] = {20, 44.0 / 3, 28.0 / 3, 4, -4, -28.0 / 3, -44.0 / 3, -20};
  ASSERT_EQ(levels.size(), std::size(expected));
  for (std::size_t k = 0; k < levels.size(); ++k) EXPECT_NEAR(levels[k], expected[k], 1e-5);
}

TYPED_TEST(CurrentStaircaseOf, EndsAtZeroAndStaysThere) {
  using T = TypeParam;
  CurrentStaircase<T> stair{short_stair<T>()};
  (void)held_levels(stair, 7);
  for (int k = 0; k < 10; ++k) (void)stair.step();
  for (int k = 0; k < 1000; ++k) {
    ASSERT_EQ(stair.step(), T(0));
    ASSERT_FALSE(stair.holds());
    ASSERT_TRUE(stair.is_done());
  }
}

TYPED_TEST(CurrentStaircaseOf, BeginsAnewAfterReset) {
  using T = TypeParam;
  CurrentStaircase<T> stair{short_stair<T>()};
  for (int k = 0; k < 60; ++k) (void)stair.step();
  stair.reset();
  EXPECT_EQ(stair.step(), T(3)) << "the first step of the ramp from zero";
  CurrentStaircase<T> fresh{short_stair<T>()};
  stair.reset();
  for (int k = 0; k < 500; ++k) ASSERT_EQ(stair.step(), fresh.step()) << k;
}

// No parameters lead beyond the highest level or move the current by more than the slope.
TYPED_TEST(CurrentStaircaseOf, KeepsLimitAndSlopeWithAnyParameters) {
  using T = TypeParam;
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  const auto between = [&random](double a, double b) {
    return std::uniform_real_distribution<double>{a, b}(random);
  };
  for (int run = 0; run < 200; ++run) {
    const T highest = T(between(0.1, 1000));
    const T slope = T(between(0.001, 3)) * highest;
    CurrentStaircase<T> stair{{.highest = highest,
                               .levels = int(between(2, 9)),
                               .slope = slope,
                               .settle_periods = int(between(1, 20)),
                               .hold_periods = int(between(1, 20))}};
    T before{};
    for (int k = 0; k < 5000; ++k) {
      const T now = stair.step();
      ASSERT_LE(std::abs(now), highest);
      ASSERT_LE(std::abs(now - before), slope * T(1.0001));
      before = now;
    }
  }
}

}  // namespace
}  // namespace sextant
