#include "sextant/core/elapsed.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t highest = std::numeric_limits<std::int64_t>::max();

TEST(Elapsed, IsTheDifference) {
  EXPECT_EQ(elapsed(10, 25), 15);
  EXPECT_EQ(elapsed(-10, 25), 35);
  EXPECT_EQ(elapsed(-25, -10), 15);
  EXPECT_EQ(elapsed(0, highest), highest);
  EXPECT_EQ(elapsed(lowest, lowest + 1), 1);
  EXPECT_EQ(elapsed(lowest, -1), highest);
}

TEST(Elapsed, IsNothingOnAClockThatStandsOrWasSetBack) {
  EXPECT_EQ(elapsed(25, 25), 0);
  EXPECT_EQ(elapsed(25, 10), 0);
  EXPECT_EQ(elapsed(highest, lowest), 0);
}

TEST(Elapsed, StopsAtTheLargestNumber) {
  EXPECT_EQ(elapsed(lowest, 0), highest);
  EXPECT_EQ(elapsed(lowest, highest), highest);
  EXPECT_EQ(elapsed(-1, highest), highest);
}

}  // namespace
}  // namespace sextant
