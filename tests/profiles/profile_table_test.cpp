#include "sextant/profiles/profile_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/text_files.hpp"

namespace sextant {
namespace {

using testing::ElementsAre;

TEST(ProfileTable, ReadsPointsAndJumps) {
  const TextFiles files;
  const std::string file = files.write("t.csv", "value,time_s\n0,0\n5,1\n-5,1\n");
  EXPECT_THAT(read_profile_table(file, -10, 10),
              ElementsAre(ProfilePoint{0, 0}, ProfilePoint{1, 5}, ProfilePoint{1, -5}));
}

TEST(ProfileTable, RefusesWithFileLineAndColumn) {
  const TextFiles files;
  const struct {
    const char* rows;
    const char* says;
  } cases[] = {
      {"0,0\n2,1\n1,1\n", ":4: time_s: point 2: the time goes back from 2 to 1 s"},
      {"0.5,0\n", ":2: time_s: point 0: the first time must be 0 s, not 0.5 s"},
      {"0,0\n1,11\n", ":3: value must be from -10 to 10, not 11"},
      {"0,0\n1,-11\n", ":3: value must be from -10 to 10, not -11"},
      {"0,0\n1,nan\n", ":3: value must be a finite number, not \"nan\""},
  };
  for (const auto& [rows, says] : cases) {
    const std::string file = files.write("t.csv", std::string{"time_s,value\n"} + rows);
    EXPECT_EQ(refusal([&file] { (void)read_profile_table(file, -10, 10); }), file + says);
  }
  const std::string other = files.write("other.csv", "time,value\n0,1\n");
  EXPECT_EQ(refusal([&other] { (void)read_profile_table(other, -10, 10); }),
            other + ":1: expected a column time_s, found time,value");
}

}  // namespace
}  // namespace sextant
