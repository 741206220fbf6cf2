#include "sextant/profiles/drive_cycle.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/source_directory.hpp"
#include "support/text_files.hpp"

namespace sextant {
namespace {

TEST(DriveCycle, TheNewYorkCityCycleIsThePublishedOne) {
  const ProfileParameters cycle = read_drive_cycle(SEXTANT_SOURCE_DIR "/configs/cycles/nycc.csv").speed;
  ASSERT_EQ(cycle.points.size(), 599U);
  EXPECT_EQ(cycle.points.back(), (ProfilePoint{598, 0}));
  double way = 0;
  double fastest = 0;
  for (std::size_t k = 1; k < cycle.points.size(); ++k) {
    way += 0.5 * (cycle.points[k - 1].value + cycle.points[k].value);
    fastest = std::max(fastest, cycle.points[k].value);
  }
  // EPA: 1.18 miles, 7.1 mph on average; 27.7 mph at most.
  EXPECT_NEAR(way / 1609.344, 1.18, 0.005);
  EXPECT_NEAR(way / 598 / 0.44704, 7.1, 0.05);
  EXPECT_NEAR(fastest / 0.44704, 27.7, 0.05);
}

TEST(DriveCycle, TakesItsUnitFromTheColumn) {
  const TextFiles files;
  const auto second = [&files](const std::string& column) {
    return read_drive_cycle(files.write("c.csv", "time_s," + column + "\n0,0\n1,36\n")).speed.points[1].value;
  };
  EXPECT_DOUBLE_EQ(second("speed_m_s"), 36);
  EXPECT_DOUBLE_EQ(second("speed_kmh"), 10);
  EXPECT_DOUBLE_EQ(second("speed_mph"), 36 * 1609.344 / 3600);
}

TEST(DriveCycle, HasTheGradeOfItsColumn) {
  const TextFiles files;
  EXPECT_FALSE(read_drive_cycle(files.write("c.csv", "time_s,speed_m_s\n0,0\n1,1\n")).grade);
  for (const char* columns :
       {"time_s,speed_m_s,grade\n0,0,0.08\n1,1,-0.02\n", "grade_percent,time_s,speed_m_s\n8,0,0\n-2,1,1\n"}) {
    const DriveCycle cycle = read_drive_cycle(files.write("c.csv", columns));
    EXPECT_EQ(cycle.speed.points, (std::vector<ProfilePoint>{{0, 0}, {1, 1}}));
    ASSERT_TRUE(cycle.grade);
    EXPECT_DOUBLE_EQ(cycle.grade->points[0].value, 0.08);
    EXPECT_DOUBLE_EQ(cycle.grade->points[1].value, -0.02);
  }
}

TEST(DriveCycle, RefusesWithFileLineAndColumn) {
  const TextFiles files;
  const struct {
    const char* text;
    const char* says;
  } cases[] = {
      {"time_s,speed_kmh\n", " is empty: expected a heading and at least one row"},
      {"time_s,speed_kmh\n0,0\n", ":2: a drive cycle needs at least two rows"},
      {"time_s,speed_kmh\n0,0\n1,-1\n", ":3: speed_kmh must not be below zero, found -1"},
      {"time_s,speed_kmh\n0,0\n2,1\n1,1\n", ":4: time_s: point 2: the time goes back from 2 to 1 s"},
      {"time_s,speed_kmh\n0,0\n1,1\n1,2\n", ":4: time_s: point 2: 1 s is the time of point 1 too"},
      {"time_s,speed_kmh\n0,0\n1,nan\n", ":3: speed_kmh must be a finite number, not \"nan\""},
      {"t,speed_kmh\n0,0\n1,1\n", ":1: expected a column time_s, found t,speed_kmh"},
      {"time_s,speed\n0,0\n1,1\n",
       ":1: expected one of the columns speed_mph, speed_kmh and speed_m_s, and at most one of grade and "
       "grade_percent, found time_s,speed"},
      {"time_s,speed_mph,speed_kmh\n0,0,0\n1,1,1\n",
       ":1: expected one of the columns speed_mph, speed_kmh and speed_m_s, and at most one of grade and "
       "grade_percent, found time_s,speed_mph,speed_kmh"},
      {"time_s,speed_kmh,grade,grade_percent\n0,0,0,0\n1,1,0,0\n",
       ":1: expected one of the columns speed_mph, speed_kmh and speed_m_s, and at most one of grade and "
       "grade_percent, found time_s,speed_kmh,grade,grade_percent"},
      {"time_s,speed_kmh,slope\n0,0,0\n1,1,0\n",
       ":1: unknown column slope; known are time_s,speed_mph,speed_kmh,speed_m_s,grade,grade_percent"},
  };
  for (const auto& [text, says] : cases) {
    const std::string file = files.write("c.csv", text);
    EXPECT_EQ(refusal([&file] { (void)read_drive_cycle(file); }), file + says);
  }
}

}  // namespace
}  // namespace sextant
