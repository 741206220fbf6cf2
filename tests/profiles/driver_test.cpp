#include "sextant/profiles/driver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "sextant/plant/vehicle_parameters.hpp"
#include "sextant/profiles/drive_cycle.hpp"
#include "sextant/profiles/profile.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr Driver::Parameters parameters{.period_ns = 10 * ms,
                                        .mass = 200,
                                        .wheel_radius = 0.28,
                                        .motors = 2,
                                        .bandwidth = 3,
                                        .integral_time = 2,
                                        .torque_limit = 80};
/// Torque of each motor for an acceleration. [m/s²] → [N·m]
constexpr double torque_for(double acceleration) {
  return 200 * acceleration * 0.28 / 2;
}

TEST(Driver, DecidesOncePerPeriodAndHolds) {
  Driver driver{parameters};
  EXPECT_EQ(driver.torque(), 0.0);
  EXPECT_NEAR(driver.step(0, 0.5, 0.0), torque_for(3 * 0.5), 1e-12)
      << "the first decision has no integral yet";
  for (std::int64_t t = 25'000; t < 10 * ms; t += 25'000)
    ASSERT_NEAR(driver.step(t, -7.0, 3.0), torque_for(3 * 0.5), 1e-12) << t;
  EXPECT_EQ(driver.next_decision_ns(), 10 * ms);
  EXPECT_LT(driver.step(10 * ms + 7, 0.4, 0.5), 0.0) << "late is soon enough";
  EXPECT_EQ(driver.next_decision_ns(), 20 * ms) << "the grid stays";
  driver.step(95 * ms, 0.0, 0.0);
  EXPECT_EQ(driver.next_decision_ns(), 105 * ms);
}

TEST(Driver, FeedsTheAccelerationForwardBothWays) {
  for (const double a : {1.5, -2.0}) {
    Driver driver{parameters};
    for (int k = 0; k < 50; ++k) {
      const double v = 10 + a * 0.01 * k;
      const double torque = driver.step(k * 10 * ms, v, v);
      EXPECT_NEAR(torque, k == 0 ? 0.0 : torque_for(a), 1e-9);
    }
  }
}

TEST(Driver, MeasuresTheTimeBetweenItsDecisionsWhereTheyComeLate) {
  Driver driver{parameters};
  for (int k = 0; k < 20; ++k) {
    const double v = 1.5 * 0.025 * k;
    EXPECT_NEAR(driver.step(k * 25 * ms, v, v), k == 0 ? 0.0 : torque_for(1.5), 1e-9);
  }
}

TEST(Driver, IntegratesTheError) {
  Driver driver{parameters};
  // 0.1 m/s for n periods before: omega_b (e + n T e/T_i)
  for (int n = 0; n < 100; ++n)
    EXPECT_NEAR(driver.step(n * 10 * ms, 0.1, 0.0), torque_for(3 * (0.1 + n * 0.01 * 0.1 / 2)), 1e-9);
}

TEST(Driver, StaysWithinItsLimitAndDoesNotWindUp) {
  Driver driver{parameters};
  std::int64_t t = 0;
  for (; t < 20'000 * ms; t += 10 * ms) ASSERT_EQ(driver.step(t, 5.0, 0.0), 80.0);
  EXPECT_LT(driver.step(t, 5.0, 5.1), 0.0) << "20 s at the limit have left nothing behind";
  driver.reset();
  for (t = 0; t < 20'000 * ms; t += 10 * ms) ASSERT_EQ(driver.step(t, 5.0, 10.0), -80.0);
  EXPECT_GT(driver.step(t, 5.0, 4.9), 0.0);
}

TEST(Driver, ResetForgets) {
  Driver used{parameters};
  for (int k = 0; k < 100; ++k) used.step(k * 10 * ms, 3.0 + k, 1.0);
  used.reset();
  Driver fresh{parameters};
  for (int k = 0; k < 100; ++k) {
    ASSERT_EQ(used.step(k * 10 * ms, 0.1 * k, 0.05 * k), fresh.step(k * 10 * ms, 0.1 * k, 0.05 * k));
  }
}

TEST(Driver, FollowsTheNewYorkCityCycleWithAnIdealDrive) {
  const Profile cycle{read_drive_cycle(SEXTANT_SOURCE_DIR "/configs/cycles/nycc.csv").speed};
  Driver driver{{.mass = 200, .wheel_radius = 0.28, .motors = 2}};
  const RoadLoad<> road =
      road_load({.mass = 200, .wheel_radius = 0.28, .rolling_coefficient = 0.01, .drag_area = 2.4});
  double omega = 0, square = 0, worst = 0, hardest_braking = 0;
  constexpr double h = 1e-3;
  for (std::int64_t k = 0; k < 598'000; ++k) {
    const double v_ref = cycle.value(k * ms);
    const double v = driver.vehicle_speed(omega);
    const double torque = driver.step(k * ms, v_ref, v);
    square += (v_ref - v) * (v_ref - v);
    worst = std::max(worst, std::abs(v_ref - v));
    if (v > 1) hardest_braking = std::min(hardest_braking, torque);
    omega += h * (torque - road.torque(omega)) / road.coupled_inertia;
  }
  EXPECT_LT(std::sqrt(square / 598'000), 0.02);
  EXPECT_LT(worst, 0.2);
  EXPECT_LT(hardest_braking, -50) << "NYCC brakes at up to 2.6 m/s²";
}

TEST(Driver, ParametersAreChecked) {
  EXPECT_EQ(Driver::Parameters{}.validate(), nullptr);
  EXPECT_EQ(parameters.validate(), nullptr);
  for (const auto member :
       {&Driver::Parameters::mass, &Driver::Parameters::wheel_radius, &Driver::Parameters::bandwidth,
        &Driver::Parameters::integral_time, &Driver::Parameters::torque_limit}) {
    for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      Driver::Parameters p = parameters;
      p.*member = bad;
      EXPECT_NE(p.validate(), nullptr);
    }
  }
  Driver::Parameters p = parameters;
  p.period_ns = 0;
  EXPECT_NE(p.validate(), nullptr);
  p = parameters;
  p.motors = 0;
  EXPECT_NE(p.validate(), nullptr);
  p = parameters;
  p.bandwidth = 101;
  EXPECT_STREQ(p.validate(), "the driver's bandwidth is too high for the period");
}

}  // namespace
}  // namespace sextant
