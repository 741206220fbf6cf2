#include "sextant/profiles/passive_ev_load.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/profiles/drive_cycle.hpp"
#include "support/source_directory.hpp"
#include "support/text_files.hpp"

namespace sextant {
namespace {

using testing::HasSubstr;
using enum PassiveEvLoad::Extrapolation;

constexpr double kmh = 1.0 / 3.6;
constexpr double rpm = std::numbers::pi / 30.0;

PassiveEvLoad table_5(PassiveEvLoad::Extrapolation extrapolation) {
  return PassiveEvLoad{
      {read_passive_ev_table(SEXTANT_SOURCE_DIR "/configs/vehicles/passive_ev.csv"), extrapolation}};
}
ProfileParameters nycc() {
  return read_drive_cycle(SEXTANT_SOURCE_DIR "/configs/cycles/nycc.csv").speed;
}

TEST(PassiveEvLoad, HoldsTable5WithTheMisprintCorrected) {
  const PassiveEvLoad load = table_5(linear);
  for (const auto& [torque, speed, wheel] :
       {std::array{10.0, 25.0, 241.0}, {50.0, 57.0, 540.0}, {80.0, 72.0, 683.0}, {100.0, 80.0, 764.0}}) {
    EXPECT_NEAR(load.torque(speed * kmh), torque, 1e-12);
    EXPECT_NEAR(load.wheel_speed(speed * kmh), wheel * rpm, 1e-12);
  }
  EXPECT_NEAR(load.torque(40 * kmh), 25.0, 1e-12) << "half-way between two rows";
  for (double v = 25; v <= 80; v += 0.1)
    EXPECT_NEAR(load.wheel_speed(v * kmh) / rpm / v, 9.52, 0.13) << "one wheel radius throughout";
}

TEST(PassiveEvLoad, BeyondTheTableTheTorqueGoesOnAsNamed) {
  const struct {
    PassiveEvLoad::Extrapolation extrapolation;
    double at_rest, at_half_of_first_row, above;
  } cases[] = {{linear, -140.0 / 11.0, 10.0 - 12.5 * 10.0 / 11.0, 110.0},
               {clip, 10.0, 10.0, 100.0},
               {origin, 0.0, 5.0, 110.0}};
  for (const auto& c : cases) {
    SCOPED_TRACE(int(c.extrapolation));
    const PassiveEvLoad load = table_5(c.extrapolation);
    EXPECT_NEAR(load.torque(0), c.at_rest, 1e-12);
    EXPECT_NEAR(load.torque(12.5 * kmh), c.at_half_of_first_row, 1e-12);
    EXPECT_NEAR(load.torque(84 * kmh), c.above, 1e-12);
    EXPECT_EQ(load.wheel_speed(0), 0.0) << "the wheel stands when the vehicle does";
    EXPECT_NEAR(load.wheel_speed(12.5 * kmh), 120.5 * rpm, 1e-12);
    EXPECT_NEAR(load.wheel_speed(84 * kmh), 803 * rpm, 1e-9);
  }
}

TEST(PassiveEvLoad, AlongACycleEveryInstantIsTheTableOfItsSpeed) {
  const ProfileParameters cycle = nycc();
  const Profile speed{cycle};
  for (const auto extrapolation : {linear, clip, origin}) {
    const PassiveEvLoad load = table_5(extrapolation);
    const PassiveEvLoad::Profiles profiles = load.along(cycle);
    const Profile torque{profiles.torque};
    const Profile wheel{profiles.wheel_speed};
    for (std::int64_t t = 0; t <= 600'000'000'000; t += 7'654'321) {
      ASSERT_NEAR(torque.value(t), load.torque(speed.value(t)), 1e-6) << t;
      ASSERT_NEAR(wheel.value(t), load.wheel_speed(speed.value(t)), 1e-6) << t;
    }
    EXPECT_TRUE(torque.jumps_ns().empty());
    EXPECT_GT(profiles.torque.points.size(), cycle.points.size()) << "corners at the rows";
  }
}

TEST(PassiveEvLoad, CornersComeWhereTheSpeedCrossesARow) {
  const PassiveEvLoad load{{{{10, 5, 30}, {20, 15, 60}, {30, 20, 90}}, linear}};
  const ProfileParameters up_and_down{.shape = ProfileShape::linear, .points = {{0, 0}, {4, 40}, {8, 0}}};
  const PassiveEvLoad::Profiles p = load.along(up_and_down);
  std::vector<double> times;
  for (const ProfilePoint& point : p.torque.points) times.push_back(point.t_s);
  EXPECT_THAT(times, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_EQ(p.torque.points[3].value, 20.0);
  EXPECT_EQ(p.torque.points[4].value, 25.0);
}

TEST(PassiveEvLoad, TheNewYorkCityCycleIsMostlyBelowTheTable) {
  const Profile speed{nycc()};
  const Profile torque{table_5(linear).along(nycc()).torque};
  const Profile clipped{table_5(clip).along(nycc()).torque};
  double below_first_row = 0, negative = 0;
  const int n = 598'000;
  for (std::int64_t k = 0; k < n; ++k) {
    below_first_row += speed.value(k * 1'000'000) < 25 * kmh;
    negative += torque.value(k * 1'000'000) < 0;
    ASSERT_GE(clipped.value(k * 1'000'000), 10 - 1e-9);
  }
  EXPECT_NEAR(below_first_row / n, 0.81, 0.01);
  EXPECT_NEAR(negative / n, 0.63, 0.01);
}

TEST(PassiveEvLoad, RefusesWhatIsNoTable) {
  const TextFiles files;
  const std::string heading = "torque_nm,vehicle_speed_kmh,wheel_speed_rpm\n";
  const auto why = [&files](const std::string& text) {
    return refusal([file = files.write("t.csv", text)] { (void)read_passive_ev_table(file); });
  };
  EXPECT_THAT(why(heading + "1,2,3\n"), HasSubstr("t.csv:2: the table needs at least two rows"));
  EXPECT_THAT(why(heading + "1,2,3\n1,2,3\n"),
              HasSubstr("t.csv:3: vehicle_speed_kmh: row 1: the vehicle speed must rise from row to row"));
  EXPECT_THAT(why(heading + "1,0,3\n"), HasSubstr("row 0: the vehicle speed must be above zero"));
  EXPECT_THAT(why("torque,vehicle_speed_kmh,wheel_speed_rpm\n1,2,3\n"),
              HasSubstr("t.csv:1: expected a column torque_nm"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([nan] { PassiveEvLoad{{{{1, nan, 1}, {2, 1, 1}}, clip}}; }),
              HasSubstr("row 0: all values must be finite"));
}

}  // namespace
}  // namespace sextant
