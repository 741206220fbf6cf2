#include "sextant/plant/road_load.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr RoadLoad<> road{.quadratic_drag = 0.02,
                          .rolling_torque = 3,
                          .rolling_speed = 0.5,
                          .grade_torque = 1.5,
                          .coupled_inertia = 7};

TEST(RoadLoad, IsNothingByDefault) {
  constexpr RoadLoad<> none{};
  EXPECT_FALSE(none.acts());
  EXPECT_EQ(none.torque(100), 0);
  EXPECT_EQ(none.slope(100), 0);
  EXPECT_EQ(none.validate(), nullptr);
}

TEST(RoadLoad, OpposesTheMotionAndPullsDownhill) {
  EXPECT_TRUE(road.acts());
  EXPECT_DOUBLE_EQ(road.torque(0), 1.5);
  EXPECT_NEAR(road.torque(50), 0.02 * 2500 + 3 + 1.5, 1e-3);
  EXPECT_NEAR(road.torque(-50), -0.02 * 2500 - 3 + 1.5, 1e-3);
  EXPECT_NEAR(road.torque(0.5) - 1.5 - 0.02 * 0.25, 3 / std::sqrt(2.0), 1e-12) << "71 % at the rolling speed";
}

TEST(RoadLoad, SlopeIsTheDerivative) {
  for (double omega = -60; omega <= 60; omega += 0.37) {
    const double h = 1e-4;
    EXPECT_NEAR(road.slope(omega), (road.torque(omega + h) - road.torque(omega - h)) / (2 * h), 1e-6)
        << omega;
  }
  EXPECT_DOUBLE_EQ(road.slope(0), 3 / 0.5);
}

TEST(RoadLoad, ParametersAreChecked) {
  EXPECT_EQ(road.validate(), nullptr);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {-1.0, nan}) {
    EXPECT_NE((RoadLoad<>{.quadratic_drag = bad}.validate()), nullptr);
    EXPECT_NE((RoadLoad<>{.rolling_torque = bad}.validate()), nullptr);
    EXPECT_NE((RoadLoad<>{.rolling_speed = bad}.validate()), nullptr);
    EXPECT_NE((RoadLoad<>{.coupled_inertia = bad}.validate()), nullptr);
  }
  EXPECT_NE((RoadLoad<>{.rolling_speed = 0}.validate()), nullptr);
  EXPECT_NE((RoadLoad<>{.grade_torque = nan}.validate()), nullptr);
  EXPECT_EQ((RoadLoad<>{.grade_torque = -5}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
