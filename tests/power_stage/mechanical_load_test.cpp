#include "sextant/power_stage/mechanical_load.hpp"

#include <cstdint>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

TEST(MechanicalLoad, ATorqueActsFromItsInstantOn) {
  const MechanicalLoad load{
      {.load_torque = {.shape = ProfileShape::steps, .points = {{0.0, 5.0}, {0.5, 10.0}}}}};
  EXPECT_FALSE(load.imposes_speed());
  EXPECT_EQ(load.torque(499'999'999), 5.0);
  EXPECT_EQ(load.torque(500'000'000), 10.0);
  EXPECT_EQ(load.next_corner_ns(0), 500'000'000);
  EXPECT_EQ(load.next_corner_ns(499'999'999), 500'000'000);
  EXPECT_EQ(load.next_corner_ns(500'000'000), never);
}

TEST(MechanicalLoad, ATorqueThatBeginsAtZeroIsNoneBefore) {
  MechanicalLoad::Parameters parameters{.load_torque = {.value = 5.0}};
  EXPECT_EQ(MechanicalLoad{parameters}.torque(-1), 5.0);
  parameters.torque_begins_at_zero = true;
  const MechanicalLoad load{parameters};
  EXPECT_EQ(load.torque(-1), 0.0);
  EXPECT_EQ(load.torque(0), 5.0);
  EXPECT_EQ(load.next_corner_ns(-1'000), 0);
}

TEST(MechanicalLoad, AnImposedSpeedHasCornersOfItsOwn) {
  const MechanicalLoad load{
      {.load_torque = {.shape = ProfileShape::steps, .points = {{0.0, 0.0}, {0.3, 1.0}}},
       .imposed_speed =
           ProfileParameters{.shape = ProfileShape::linear, .points = {{0.0, 0.0}, {0.2, 40.0}}}}};
  EXPECT_TRUE(load.imposes_speed());
  EXPECT_DOUBLE_EQ(load.speed(100'000'000), 20.0);
  EXPECT_DOUBLE_EQ(load.speed(900'000'000), 40.0);
  EXPECT_EQ(load.next_corner_ns(0), 200'000'000);
  EXPECT_EQ(load.next_corner_ns(200'000'000), 300'000'000);
}

TEST(MechanicalLoad, RefusesAMalformedProfile) {
  const ProfileParameters backwards{.shape = ProfileShape::steps,
                                    .points = {{0.0, 0.0}, {1.0, 1.0}, {0.5, 2.0}}};
  EXPECT_THROW((MechanicalLoad{{.load_torque = backwards}}), std::runtime_error);
  EXPECT_THROW((MechanicalLoad{{.imposed_speed = backwards}}), std::runtime_error);
}

}  // namespace
}  // namespace sextant
