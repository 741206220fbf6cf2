#include "sextant/profiles/profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

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

/// Sines from the slowest that moves in a second to the fastest allowed.
std::vector<ProfileParameters> sines() {
  return {{.shape = ProfileShape::sine, .amplitude = 15, .frequency_hz = 0.5},
          {.shape = ProfileShape::sine, .value = -3, .amplitude = 20, .frequency_hz = 0.37, .phase_deg = 90},
          {.shape = ProfileShape::sine, .value = 1, .amplitude = -7, .frequency_hz = 50, .phase_deg = -33},
          {.shape = ProfileShape::sine, .amplitude = 1, .frequency_hz = 1000, .phase_deg = 10}};
}

TEST(Profile, SineIsThatToWithinItsChords) {
  for (const ProfileParameters& s : sines()) {
    SCOPED_TRACE(s.frequency_hz);
    const Profile p{s};
    constexpr unsigned seed = 21;
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{seed};
    std::uniform_real_distribution<double> when{0, 600};
    double worst = 0;
    for (int k = 0; k < 20'000; ++k) {
      const std::int64_t t = std::llround(when(random) * 1e9);
      const double angle =
          2 * std::numbers::pi * s.frequency_hz * (double(t) * 1e-9) + s.phase_deg * std::numbers::pi / 180;
      worst = std::max(worst, std::abs(p.value(t) - s.value - s.amplitude * std::sin(angle)));
    }
    // 1.234e-6 where the sine is steepest in its bend; chords of 500 ns are up to 1 ns longer.
    EXPECT_LT(worst, 1.25e-6 * std::abs(s.amplitude));
    EXPECT_GT(worst, 1.1e-6 * std::abs(s.amplitude)) << "the documented error is reached";
    EXPECT_THAT(p.jumps_ns(), IsEmpty());
  }
}

TEST(Profile, SineHasTwoThousandCornersAPeriodWithItsValueOnEach) {
  for (const ProfileParameters& s : sines()) {
    SCOPED_TRACE(s.frequency_hz);
    const Profile p{s};
    const std::int64_t begin = std::llround(7e9 / s.frequency_hz) - 1;
    const std::int64_t end = std::llround(10e9 / s.frequency_hz) - 1;
    int corners = 0;
    for (std::int64_t t = p.next_corner_ns(begin); t <= end; t = p.next_corner_ns(t)) {
      ++corners;
      const double angle =
          2 * std::numbers::pi * s.frequency_hz * (double(t) * 1e-9) + s.phase_deg * std::numbers::pi / 180;
      EXPECT_NEAR(p.value(t), s.value + s.amplitude * std::sin(angle), 1e-9 * std::abs(s.amplitude));
      const double slope = p.slope(t);
      const std::int64_t next = p.next_corner_ns(t);
      ASSERT_GT(next, t);
      const std::int64_t middle = (t + next) / 2;
      EXPECT_EQ(p.slope(middle), slope);
      EXPECT_EQ(p.next_corner_ns(middle), next);
      EXPECT_NEAR(p.value(next), p.value(t) + slope * double(next - t) * 1e-9, 1e-9 * std::abs(s.amplitude));
    }
    EXPECT_NEAR(corners, 6000, 1);
  }
}

TEST(Profile, SineWithoutAmplitudeIsItsOffset) {
  const Profile p{{.shape = ProfileShape::sine, .value = 4}};
  EXPECT_EQ(p.value(123 * ms), 4);
  EXPECT_EQ(p.next_corner_ns(0), std::numeric_limits<std::int64_t>::max());
}

TEST(Profile, SineHoldsBeforeTimeZeroAndSurvivesTheEndOfTime) {
  const Profile p{sines()[1]};
  EXPECT_DOUBLE_EQ(p.value(-5 * ms), 17);
  EXPECT_EQ(p.slope(-1), 0);
  EXPECT_EQ(p.next_corner_ns(-1), 0);
  EXPECT_TRUE(std::isfinite(p.value(std::numeric_limits<std::int64_t>::max())));
}

TEST(Profile, TableIsLinearBetweenItsRows) {
  const Profile p{{.shape = ProfileShape::table, .table = {{0, 0}, {1, 10}, {1, -10}, {2, -10}}}};
  EXPECT_DOUBLE_EQ(p.value(500 * ms), 5);
  EXPECT_EQ(p.value(1000 * ms), -10);
  EXPECT_EQ(p.next_corner_ns(0), 1000 * ms);
  EXPECT_THAT(p.jumps_ns(), ElementsAre(1000 * ms));
}

TEST(Profile, LooksUpTheSameInAnyOrder) {
  constexpr unsigned seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  std::uniform_int_distribution<std::int64_t> when{-ms, 6000 * ms};
  const ProfileParameters list{.shape = ProfileShape::linear,
                               .points = {{0, 2}, {1, 4}, {1, 5}, {3, 0}, {3.2, 7}, {5, -7}}};
  for (const ProfileParameters& parameters : {list, sines()[0], sines()[1]}) {
    const Profile used{parameters};
    for (int k = 0; k < 1000; ++k) {
      const std::int64_t t = when(random);
      const Profile fresh{parameters};
      ASSERT_EQ(used.value(t), fresh.value(t)) << t;
      ASSERT_EQ(used.slope(t), fresh.slope(t)) << t;
      ASSERT_EQ(used.next_corner_ns(t), fresh.next_corner_ns(t)) << t;
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
      {{.shape = steps, .points = {{0, 1}, {3, 1}, {2, 2}}}, "point 2: the time goes back from 3 to 2 s"},
      {{.shape = linear, .points = {{0, 1}, {-1, 1}}}, "point 1: the time goes back from 0 to -1 s"},
      {{.shape = linear, .points = {{0, 1}, {0, 2}}}, "the time stands still at 0 s in every point"},
      {{.shape = table, .table = {{0, 1}, {0, 2}, {0, 3}}}, "the time stands still at 0 s in every point"},
      {{.shape = steps, .points = {{0, 1}, {1, 1}, {1, 2}}}, "point 2: 1 s is the time of point 1 too"},
      {{.shape = linear, .points = {{0, 1}, {1e12, 1}}}, "point 1: the time must be at most"},
      {{.shape = table}, "a table needs the key file"},
      {{.shape = table, .table = {{0, 1}, {2, 1}, {1, 1}}}, "point 2: the time goes back from 2 to 1 s"},
      {{.shape = sine, .value = inf, .amplitude = 1}, "the value must be finite"},
      {{.shape = sine, .amplitude = nan}, "the amplitude must be finite"},
      {{.shape = sine, .amplitude = 1, .frequency_hz = 0}, "the frequency must be from"},
      {{.shape = sine, .amplitude = 1, .frequency_hz = nan}, "the frequency must be from"},
      {{.shape = sine, .amplitude = 1, .frequency_hz = 2e3}, "the frequency must be from"},
      {{.shape = sine, .amplitude = 1, .phase_deg = inf}, "the phase must be finite"},
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
