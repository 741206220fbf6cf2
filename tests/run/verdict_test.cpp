#include "sextant/run/verdict.hpp"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(Verdict, EachHasAWordAndAFailureAStatusOfItsOwn) {
  std::set<std::string> words;
  std::set<int> statuses{
      2, expectation_missing_status};  // of a command that is wrong, and of a missing [expect]
  for (const VerdictInfo& verdict : verdict_catalogue) {
    EXPECT_TRUE(words.insert(verdict.word).second) << verdict.word;
    if (verdict.status == 0) continue;
    EXPECT_TRUE(statuses.insert(verdict.status).second) << verdict.word;
  }
  EXPECT_STREQ(to_string(Verdict::interrupted), "interrupted");
  EXPECT_STREQ(to_string(Verdict::no_torque), "no_torque");
  EXPECT_STREQ(to_string(Verdict::pass), "pass");
}

TEST(Verdict, StatusesThatProgramsRelyOn) {
  EXPECT_EQ(exit_status(Verdict::pass), 0);
  EXPECT_EQ(exit_status(Verdict::fail), 1);
  EXPECT_EQ(exit_status(Verdict::tripped), 3);
  EXPECT_EQ(exit_status(Verdict::no_torque), 4);
  EXPECT_EQ(exit_status(Verdict::not_followed), 5);
  EXPECT_EQ(exit_status(Verdict::nothing_expected), 0);
  EXPECT_EQ(exit_status(Verdict::nothing_expected, true), 9);
  EXPECT_EQ(exit_status(Verdict::interrupted), 128);
}

}  // namespace
}  // namespace sextant
