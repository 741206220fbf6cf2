#include "sextant/realtime/overrun.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t limit_ns = 10'000;
constexpr std::int64_t wake_period_ns = 25'000;

/// One gap, and nothing else.
constexpr Gap gap_of(std::int64_t duration_ns, GapPlace place) {
  return {duration_ns, place, duration_ns};
}

TEST(OverrunCause, AGapThatIsLongEnoughDecidesBeforeTheExecution) {
  for (const bool execution_overran : {false, true}) {
    const Overrun waiting{.latency_ns = 35'000,
                          .gap = gap_of(10'001, GapPlace::waiting),
                          .execution_overran = execution_overran};
    EXPECT_EQ(visible_cause(waiting, wake_period_ns), OverrunCause::machine_gap);
    for (const GapPlace place : {GapPlace::read, GapPlace::push, GapPlace::between}) {
      const Overrun executing{
          .latency_ns = 35'000, .gap = gap_of(10'001, place), .execution_overran = execution_overran};
      EXPECT_EQ(visible_cause(executing, wake_period_ns), OverrunCause::stage_gap);
    }
  }
}

TEST(OverrunCause, AShortGapDoesNotExcuseALongExecution) {
  for (const GapPlace place : {GapPlace::waiting, GapPlace::read}) {
    const Overrun overrun{.latency_ns = 1'000'000, .gap = gap_of(10'100, place), .execution_overran = true};
    EXPECT_EQ(visible_cause(overrun, wake_period_ns), OverrunCause::long_execution);
  }
  const Gap just_too_short = gap_of(40'000 - wake_period_ns, GapPlace::read);
  EXPECT_EQ(
      visible_cause({.latency_ns = 40'000, .gap = just_too_short, .execution_overran = true}, wake_period_ns),
      OverrunCause::long_execution);
}

TEST(OverrunCause, SeveralGapsAccountForItTogether) {
  const Gap gaps{2'000'000, GapPlace::read, 2'060'000};
  EXPECT_EQ(visible_cause({.latency_ns = 2'060'000, .gap = gaps, .execution_overran = true}, wake_period_ns),
            OverrunCause::stage_gap);
}

TEST(OverrunCause, WithoutAGapItIsTheExecutionOrTheWakeUp) {
  EXPECT_EQ(visible_cause({.latency_ns = 25'000, .execution_overran = true}, wake_period_ns),
            OverrunCause::long_execution);
  EXPECT_EQ(visible_cause({.latency_ns = 25'000, .execution_overran = false}, wake_period_ns),
            OverrunCause::late_wake);
}

TEST(OverrunCause, AGapIsTheLongestThatWasSeenAndTheSumOfAll) {
  Gap gap;
  gap.add(5, GapPlace::read, 4);
  gap.add(7, GapPlace::waiting, 4);
  gap.add(4, GapPlace::commands, 4);
  gap.add(6, GapPlace::drive, 4);
  gap.add(7, GapPlace::push, 4);
  EXPECT_EQ(gap.longest_ns, 7);
  EXPECT_EQ(gap.place, GapPlace::waiting);
  EXPECT_EQ(gap.sum_ns, 25);
}

TEST(OverrunCause, AGapThatWasMadeUpForFades) {
  Gap gap = gap_of(20'000, GapPlace::read);
  gap.fade(30'000, limit_ns);
  EXPECT_EQ(gap.sum_ns, 20'000) << "something else has made it later still";
  gap.fade(15'000, limit_ns);
  EXPECT_EQ(gap.sum_ns, 15'000);
  EXPECT_EQ(gap.longest_ns, 20'000);
  gap.fade(limit_ns, limit_ns);
  EXPECT_EQ(gap.sum_ns, 0);
  EXPECT_EQ(gap.longest_ns, 0);
}

TEST(OverrunCause, EveryPlaceAndCauseHasItsOwnName) {
  EXPECT_STREQ(to_string(GapPlace::waiting), "while waiting");
  EXPECT_STREQ(to_string(GapPlace::write), "in write");
  EXPECT_STREQ(to_string(OverrunCause::machine_gap), "machine gap");
  EXPECT_STREQ(to_string(OverrunCause::long_execution), "own execution");
  EXPECT_STREQ(to_string(Stage::push), "push");
}

}  // namespace
}  // namespace sextant
