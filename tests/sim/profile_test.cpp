#include "sextant/sim/profile.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t ms = 1'000'000;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

Profile steps(std::vector<ProfilePoint> points) {
  return Profile{{.shape = ProfileShape::steps, .points = std::move(points)}};
}
Profile linear(std::vector<ProfilePoint> points) {
  return Profile{{.shape = ProfileShape::linear, .points = std::move(points)}};
}

TEST(Profile, IsZeroByDefault) {
  EXPECT_EQ(Profile{}.value(0), 0);
  EXPECT_EQ(Profile{}.value(1000 * ms), 0);
}

TEST(Profile, ConstantHoldsItsValue) {
  const Profile p{{.value = -12.5}};
  for (const std::int64_t t : {-1L, 0L, 1L, 3'600'000L * ms}) {
    EXPECT_EQ(p.value(t), -12.5);
    EXPECT_EQ(p.slope(t), 0);
  }
  EXPECT_THAT(p.jumps_ns(), IsEmpty());
}

TEST(Profile, StepsCountFromTheirOwnNanosecond) {
  const Profile p = steps({{0, 0}, {0.1, 15}, {0.3, 15}, {0.5, -15}});
  EXPECT_EQ(p.value(-5), 0);
  EXPECT_EQ(p.value(100 * ms - 1), 0);
  EXPECT_EQ(p.value(100 * ms), 15);
  EXPECT_EQ(p.value(499 * ms), 15);
  EXPECT_EQ(p.value(500 * ms), -15);
  EXPECT_EQ(p.value(std::numeric_limits<std::int64_t>::max()), -15);
  EXPECT_EQ(p.slope(100 * ms), 0);
  EXPECT_THAT(p.jumps_ns(), ElementsAre(100 * ms, 500 * ms)) << "a point that repeats the value is no jump";
}

TEST(Profile, LinearTableInterpolatesAndHoldsItsLastValue) {
  const Profile p = linear({{0, 2}, {1, 4}, {3, 0}});
  EXPECT_EQ(p.value(-ms), 2);
  EXPECT_EQ(p.value(0), 2);
  EXPECT_DOUBLE_EQ(p.value(500 * ms), 3);
  EXPECT_DOUBLE_EQ(p.value(1000 * ms), 4);
  EXPECT_DOUBLE_EQ(p.value(2500 * ms), 1);
  EXPECT_EQ(p.value(3000 * ms), 0);
  EXPECT_EQ(p.value(9000 * ms), 0);
  EXPECT_EQ(p.slope(-1), 0);
  EXPECT_DOUBLE_EQ(p.slope(0), 2);
  EXPECT_DOUBLE_EQ(p.slope(1000 * ms), -2);
  EXPECT_EQ(p.slope(3000 * ms), 0);
  EXPECT_THAT(p.jumps_ns(), IsEmpty());
}

TEST(Profile, TwoLinearPointsAtOneTimeAreAJump) {
  const Profile p = linear({{0, 0}, {1, 10}, {1, -10}, {2, -10}});
  EXPECT_NEAR(p.value(1000 * ms - 1), 10, 1e-7);
  EXPECT_EQ(p.value(1000 * ms), -10);
  EXPECT_EQ(p.slope(1000 * ms), 0);
  EXPECT_THAT(p.jumps_ns(), ElementsAre(1000 * ms));
}

TEST(Profile, LinearTableIsContinuousAndItsSlopeIsItsDerivative) {
  for (const unsigned seed : {11U, 12U, 13U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{seed};
    std::uniform_real_distribution<double> gap{0.01, 2.0};
    std::uniform_real_distribution<double> level{-150, 150};
    std::vector<ProfilePoint> points{{0, level(random)}};
    for (int k = 0; k < 50; ++k) points.push_back({points.back().t_s + gap(random), level(random)});
    const Profile p = linear(points);
    for (std::size_t k = 1; k < points.size(); ++k) {
      const std::int64_t t = std::llround(points[k].t_s * 1e9);
      EXPECT_NEAR(p.value(t - 1), p.value(t), 1e-4);
      const std::int64_t h = ms;
      EXPECT_NEAR((p.value(t - ms) - p.value(t - ms - h)) / (double(h) * 1e-9), p.slope(t - ms - h), 1e-6);
    }
  }
}

TEST(Profile, RefusesWhatIsNotAProfileAndNamesThePoint) {
  struct Case {
    ProfileParameters parameters;
    const char* says;
  };
  using enum ProfileShape;
  const Case cases[] = {
      {{.value = nan}, "the value must be finite"},
      {{.shape = steps}, "must not be empty"},
      {{.shape = linear}, "must not be empty"},
      {{.shape = steps, .points = {{0, 1}, {nan, 2}}}, "point 1: the time must be finite"},
      {{.shape = steps, .points = {{0, 1}, {1, 1}, {2, inf}}}, "point 2: the value must be finite"},
      {{.shape = steps, .points = {{0.5, 1}}}, "point 0: the first time must be 0 s, not 0.5 s"},
      {{.shape = steps, .points = {{0, 1}, {3, 1}, {2, 2}}}, "point 2: 2 s is before point 1"},
      {{.shape = linear, .points = {{0, 1}, {-1, 1}}}, "point 1: -1 s is before point 0"},
      {{.shape = steps, .points = {{0, 1}, {1, 1}, {1, 2}}}, "point 2: 1 s is the time of point 1 too"},
      {{.shape = linear, .points = {{0, 1}, {1e12, 1}}}, "point 1: the time must be at most"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.says);
    EXPECT_THAT(c.parameters.validate(), HasSubstr(c.says));
    try {
      static_cast<void>(Profile{c.parameters});
      ADD_FAILURE() << "accepted";
    } catch (const std::runtime_error& e) {
      EXPECT_THAT(e.what(), HasSubstr(c.says));
    }
  }
}

}  // namespace
}  // namespace sextant
