#include "sextant/recording/trace_reducer.hpp"

#include <cstdint>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 25'000;

bool add(TraceReducer& reducer, std::int64_t k) {
  const PlantSample plant{.torque = -double(k), .omega_m = 10 + double(k)};
  reducer.add_segment(plant, plant, 25e-6);
  return reducer.add({.t_ns = k * period_ns, .torque = double(k)}, plant);
}

TEST(TraceReducer, CompletesARowWithItsLastPeriod) {
  TraceReducer reducer{3};
  EXPECT_FALSE(add(reducer, 1));
  EXPECT_FALSE(add(reducer, 2));
  ASSERT_TRUE(add(reducer, 6));
  const TraceRow row = reducer.take();
  EXPECT_EQ(row.drive.t_ns, 6 * period_ns);
  EXPECT_EQ(row.drive.periods, 3U);
  EXPECT_DOUBLE_EQ(row.drive.torque_mean_nm, 3);
  EXPECT_DOUBLE_EQ(row.plant.torque_mean_nm, -3);
  EXPECT_EQ(row.plant.torque_min_nm, -6);
  EXPECT_EQ(row.plant.torque_max_nm, -1);
  EXPECT_EQ(row.plant.torque_nm, -6);
  EXPECT_EQ(row.plant.omega_m_rad_s, 16);
}

TEST(TraceReducer, ARowKnowsNothingOfTheOneBefore) {
  TraceReducer reducer{2};
  EXPECT_FALSE(add(reducer, 100));
  ASSERT_TRUE(add(reducer, 200));
  (void)reducer.take();
  EXPECT_TRUE(reducer.empty());
  EXPECT_FALSE(add(reducer, 1));
  EXPECT_FALSE(reducer.empty());
  const TraceRow row = reducer.take();
  EXPECT_EQ(row.drive.periods, 1U) << "what is left of a run may be less than an interval";
  EXPECT_EQ(row.drive.torque_max_nm, 1);
  EXPECT_EQ(row.plant.torque_mean_nm, -1);
  EXPECT_TRUE(reducer.empty());
}

}  // namespace
}  // namespace sextant
