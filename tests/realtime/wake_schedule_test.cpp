#include "sextant/realtime/wake_schedule.hpp"

#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

struct Row {
  std::int64_t now_ns;
  WakeSchedule::Wake wake;
  std::int64_t next_deadline_ns;
};

TEST(WakeSchedule, FollowsTheTable) {
  // Wake period 4 · 25 µs = 100 µs, grid through 1000 ns: deadlines at 101000, 201000, …
  WakeSchedule schedule{{25'000, 4}};
  schedule.start(1'000);
  EXPECT_EQ(schedule.next_deadline_ns(), 101'000);
  const Row rows[] = {
      {101'000, {101'000, 0, 0}, 201'000},               // on time
      {201'001, {201'000, 1, 0}, 301'000},               // a little late
      {400'999, {301'000, 99'999, 0}, 401'000},          // one nanosecond short of a whole wake period
      {401'000, {401'000, 0, 0}, 501'000},               // caught up
      {601'000, {601'000, 100'000, 4}, 701'000},         // exactly one wake period late: one is missed
      {1'033'000, {1'001'000, 332'000, 12}, 1'101'000},  // three whole ones and a part
      {1'100'000, {1'101'000, 0, 0}, 1'201'000},  // early by the clock's rounding: not a negative latency
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.now_ns);
    EXPECT_EQ(schedule.wake(row.now_ns), row.wake);
    EXPECT_EQ(schedule.next_deadline_ns(), row.next_deadline_ns);
  }
  EXPECT_EQ(schedule.counters().wakes, 7U);
  EXPECT_EQ(schedule.counters().overruns, 2U);
  EXPECT_EQ(schedule.counters().periods_missed, 16U);
}

TEST(WakeSchedule, CountsOverrunsInARowUntilOneWakeUpIsInTime) {
  WakeSchedule schedule{{100, 1}};
  schedule.start(0);
  const auto late = [&schedule] { schedule.wake(schedule.next_deadline_ns() + 250); };
  late();
  late();
  late();
  EXPECT_EQ(schedule.counters().overruns_in_a_row, 3U);
  schedule.wake(schedule.next_deadline_ns());
  EXPECT_EQ(schedule.counters().overruns_in_a_row, 0U);
  EXPECT_EQ(schedule.counters().overruns, 3U);
  EXPECT_EQ(schedule.counters().periods_missed, 6U);
}

TEST(WakeSchedule, StartForgetsThePast) {
  WakeSchedule schedule{{100, 1}};
  schedule.start(0);
  schedule.wake(1'000);
  schedule.start(5'000);
  EXPECT_EQ(schedule.next_deadline_ns(), 5'100);
  EXPECT_EQ(schedule.counters().wakes, 0U);
  EXPECT_EQ(schedule.counters().overruns, 0U);
}

TEST(WakeSchedule, KeepsPhaseAndAccountsForEveryPeriodWhateverTheLatency) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random{seed};
    std::uniform_int_distribution<std::int64_t> latency_ns{0, 5'000};
    const WakeSchedule::Parameters parameters{125, 8};
    constexpr std::int64_t origin_ns = 77;
    WakeSchedule schedule{parameters};
    schedule.start(origin_ns);
    std::int64_t now_ns = origin_ns;
    for (int i = 0; i < 1'000; ++i) {
      now_ns = std::max(now_ns, schedule.next_deadline_ns()) + latency_ns(random);
      const WakeSchedule::Wake wake = schedule.wake(now_ns);
      ASSERT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
      ASSERT_LE(wake.deadline_ns, now_ns);
      ASSERT_GT(wake.deadline_ns + parameters.wake_period_ns(), now_ns);
      const auto run = static_cast<std::int64_t>(schedule.counters().wakes) * parameters.wake_every_periods;
      const auto missed = static_cast<std::int64_t>(schedule.counters().periods_missed);
      ASSERT_EQ((run + missed) * parameters.period_ns, wake.deadline_ns - origin_ns);
    }
    EXPECT_GT(schedule.counters().overruns, 0U);
  }
}

TEST(WakeSchedule, TheGridCanStandBeforeWholeMultiplesOfTheWakePeriod) {
  constexpr std::int64_t lead_ns = 6'000;
  for (const std::int64_t period_ns : {25'000, 250'000, 1'000}) {
    for (const std::int64_t now_ns : {0L, 1L, 18'999L, 19'000L, 19'001L, 7'000'000'012'345L}) {
      SCOPED_TRACE(testing::Message() << period_ns << " from " << now_ns);
      const std::int64_t origin_ns = WakeSchedule::origin_before_tick(now_ns, lead_ns, period_ns);
      EXPECT_GE(origin_ns, now_ns);
      EXPECT_LT(origin_ns, now_ns + period_ns) << "no period is wasted";
      EXPECT_EQ((origin_ns + lead_ns) % period_ns, 0);
    }
  }
}

TEST(WakeSchedule, ParametersAreChecked) {
  EXPECT_EQ(WakeSchedule::Parameters{}.validate(), nullptr);
  EXPECT_NE((WakeSchedule::Parameters{0, 1}.validate()), nullptr);
  EXPECT_NE((WakeSchedule::Parameters{25'000, 0}.validate()), nullptr);
  EXPECT_EQ((WakeSchedule::Parameters{25'000, 40}.wake_period_ns()), 1'000'000);
}

}  // namespace
}  // namespace sextant
