#include "sextant/realtime/miss.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t limit_ns = 10'000;

TEST(Miss, TheGapDecidesBeforeTheWork) {
  for (const bool body_overran : {false, true}) {
    const Miss waiting{.gap = {limit_ns + 1, GapPlace::waiting}, .body_overran = body_overran};
    EXPECT_EQ(visible_cause(waiting, limit_ns), MissCause::machine_gap);
    for (const GapPlace place : {GapPlace::read, GapPlace::push, GapPlace::between}) {
      const Miss working{.gap = {limit_ns + 1, place}, .body_overran = body_overran};
      EXPECT_EQ(visible_cause(working, limit_ns), MissCause::stage_gap);
    }
  }
}

TEST(Miss, WithoutAGapItIsTheWorkOrTheWakeUp) {
  const Gap no_gap{limit_ns, GapPlace::waiting};
  EXPECT_EQ(visible_cause({.gap = no_gap, .body_overran = true}, limit_ns), MissCause::own_body);
  EXPECT_EQ(visible_cause({.gap = no_gap, .body_overran = false}, limit_ns), MissCause::late_wake);
}

TEST(Miss, AGapIsTheLongestThatWasSeen) {
  Gap gap;
  gap.see(5, GapPlace::read);
  gap.see(7, GapPlace::waiting);
  gap.see(6, GapPlace::drive);
  gap.see(7, GapPlace::push);
  EXPECT_EQ(gap.longest_ns, 7);
  EXPECT_EQ(gap.place, GapPlace::waiting);
}

TEST(Miss, EveryPlaceAndCauseHasItsOwnName) {
  EXPECT_STREQ(to_string(GapPlace::waiting), "while waiting");
  EXPECT_STREQ(to_string(GapPlace::write), "in write");
  EXPECT_STREQ(to_string(MissCause::machine_gap), "machine stopped us");
  EXPECT_STREQ(to_string(MissCause::own_body), "own body");
  EXPECT_STREQ(to_string(Stage::push), "push");
}

}  // namespace
}  // namespace sextant
