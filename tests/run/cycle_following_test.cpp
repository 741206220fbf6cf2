#include "sextant/run/cycle_following.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr double km_h = 1 / 3.6;  // [m/s]

/// To 50 km/h within 10 s, held for 10 s, and back.
ProfileParameters cycle() {
  return {.shape = ProfileShape::table, .table = {{0, 0}, {10, 50 * km_h}, {20, 50 * km_h}, {30, 0}}};
}

/// speed: of the cycle [m/s] and the time [s] to that of the vehicle [m/s].
std::optional<CycleDeparture> departure(const std::function<double(double speed, double t_s)>& speed,
                                        std::int64_t step_ns = 5 * ms) {
  CycleFollowing following{cycle()};
  const Profile reference{cycle()};
  for (std::int64_t t = 0; t <= 30'000 * ms; t += step_ns)
    following.add(t, speed(reference.value(t), double(t) * 1e-9));
  return following.departure();
}

TEST(CycleFollowing, TheBandIsTwoKilometresAnHourAroundTheCycle) {
  const auto beside = [](double offset_km_h) {
    return [=](double speed, double) { return speed + offset_km_h * km_h; };
  };
  EXPECT_FALSE(departure(beside(0)));
  EXPECT_FALSE(departure(beside(1.99)));
  EXPECT_FALSE(departure(beside(-1.99)));
  EXPECT_TRUE(departure(beside(2.01)));
  EXPECT_TRUE(departure(beside(-2.01)));
}

TEST(CycleFollowing, ASecondOfTheCycleBeforeAndAfterCounts) {
  const Profile reference{cycle()};
  const auto late = [&](double seconds) {
    return [&reference, seconds](double, double t_s) {
      return reference.value(std::llround((t_s - seconds) * 1e9));
    };
  };
  EXPECT_FALSE(departure(late(1)));
  EXPECT_FALSE(departure(late(1.35))) << "a second and 0.4 s of 5 km/h/s";
  EXPECT_TRUE(departure(late(1.45)));
  EXPECT_FALSE(departure(late(-1.35))) << "early";
  EXPECT_TRUE(departure(late(-1.45)));
}

TEST(CycleFollowing, ASecondOutsideIsTolerated) {
  const auto lapse = [](double duration_s) {
    return [=](double speed, double t_s) { return t_s >= 14 && t_s < 14 + duration_s ? 0.0 : speed; };
  };
  EXPECT_FALSE(departure(lapse(0.95)));
  const std::optional<CycleDeparture> found = departure(lapse(2.0));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->from_ns, 14'000 * ms);
  EXPECT_NEAR(double(found->duration_ns) * 1e-9, 2.0, 0.02);
  EXPECT_NEAR(found->farthest, 50 * km_h, 1e-9);
}

TEST(CycleFollowing, DoesNotDependOnHowOftenItIsTold) {
  const auto slow = [](double speed, double) { return std::fmin(speed, 30 * km_h); };
  for (const std::int64_t step_ns : {25'000L, 250'000L, 10'000'000L, 30'000'000L}) {
    const std::optional<CycleDeparture> found = departure(slow, step_ns);
    ASSERT_TRUE(found) << step_ns;
    // 32 km/h are passed at 6.4 s, where the lowest speed within a second is that of a second before.
    EXPECT_NEAR(double(found->from_ns) * 1e-9, 7.4, 0.05);
    EXPECT_NEAR(double(found->duration_ns) * 1e-9, 15.2, 0.1);
    EXPECT_NEAR(found->farthest, 20 * km_h, 1e-9);
  }
}

TEST(CycleFollowing, AShortRunOfALongCycle) {
  CycleFollowing following{cycle()};
  for (std::int64_t t = 0; t <= 2'000 * ms; t += 10 * ms) following.add(t, 0);
  EXPECT_FALSE(following.departure()) << "it is a few km/h behind for less than a second";
}

}  // namespace
}  // namespace sextant
