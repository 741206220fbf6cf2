#include "ecu/timing/timing_statistics.hpp"

#include <cstdio>
#include <memory>
#include <numeric>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ecu/timing/timing_report.hpp"

namespace sextant::ecu {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::int64_t ms = 1'000'000;

constexpr std::int64_t wake_period_ns = 250'000;

/// One gap, and nothing else.
Gap gap_of(std::int64_t duration_ns, GapPlace place) {
  return {duration_ns, place, duration_ns};
}

WakeRecord overrun_at(std::int64_t t_ns, std::int64_t latency_ns, Gap gap, bool execution_overran) {
  return {.deadline_ns = t_ns,
          .latency_ns = latency_ns,
          .overrun = true,
          .execution_overran = execution_overran,
          .gap = gap,
          .longest_gap_ns = gap.longest_ns};
}

class TimingStatisticsTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::uint64_t count(OverrunCause cause) const {
    return statistics->causes()[static_cast<std::size_t>(cause)];
  }
  [[nodiscard]] std::uint64_t counted() const {
    return std::accumulate(statistics->causes().begin(), statistics->causes().end(), std::uint64_t{0});
  }

  std::unique_ptr<TimingStatistics> statistics = std::make_unique<TimingStatistics>(
      TimingStatistics::Parameters{.gap_limit_ns = 10'000, .wake_period_ns = wake_period_ns});
};

TEST_F(TimingStatisticsTest, AnOverrunWhileWaitingNeedsNoWitness) {
  statistics->add(overrun_at(1 * ms, 300'000, gap_of(300'000, GapPlace::waiting), false));
  statistics->add(overrun_at(2 * ms, 200'000, {}, false));
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);
  EXPECT_EQ(count(OverrunCause::late_wake), 1U);
  EXPECT_EQ(statistics->without_gap(), 1U);
  EXPECT_EQ(statistics->gaps(), 1U);
}

TEST_F(TimingStatisticsTest, AGapInAStageWaitsForTheKernelsWord) {
  const WakeRecord in_a_stage = overrun_at(10 * ms, 300'000, gap_of(400'000, GapPlace::read), true);
  statistics->add(in_a_stage);
  EXPECT_EQ(counted(), 0U);
  statistics->add(SchedulerSample{.t_ns = 10 * ms, .valid = true});
  EXPECT_EQ(counted(), 0U) << "the sample was taken before the miss was over";
  statistics->add(
      SchedulerSample{.t_ns = 11 * ms, .run_delay_ns = 400'000, .involuntary_switches = 1, .valid = true});
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);

  statistics->add(overrun_at(20 * ms, 300'000, gap_of(400'000, GapPlace::read), true));
  statistics->add(
      SchedulerSample{.t_ns = 30 * ms, .run_delay_ns = 799'999, .involuntary_switches = 2, .valid = true});
  EXPECT_EQ(count(OverrunCause::stage_gap), 1U) << "grown by less than the gap";
  EXPECT_EQ(statistics->without_gap(), 0U);
}

// The processor is taken at 80 ms and given back at 130 ms.
TEST_F(TimingStatisticsTest, AStopAcrossASampleIsTheMachines) {
  statistics->add(SchedulerSample{.t_ns = 100 * ms, .involuntary_switches = 1, .valid = true});
  statistics->add(overrun_at(130 * ms, 50 * ms, gap_of(50 * ms, GapPlace::read), true));
  statistics->add(
      SchedulerSample{.t_ns = 200 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);
}

// The sample comes while the work after the miss still runs: the miss is in the ring only later.
TEST_F(TimingStatisticsTest, AnOverrunThatComesAfterItsSampleIsEvaluatedWithIt) {
  statistics->add(
      SchedulerSample{.t_ns = 100 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  statistics->add(overrun_at(99 * ms, 50 * ms, gap_of(50 * ms, GapPlace::read), true));
  statistics->add(
      SchedulerSample{.t_ns = 200 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);
}

TEST_F(TimingStatisticsTest, WhatIsLeftOverIsForgottenAfterOneSample) {
  for (int k = 1; k <= 2; ++k) {
    statistics->add(SchedulerSample{
        .t_ns = k * 100 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  }
  statistics->add(overrun_at(250 * ms, 50 * ms, gap_of(50 * ms, GapPlace::read), true));
  statistics->add(
      SchedulerSample{.t_ns = 300 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  EXPECT_EQ(count(OverrunCause::stage_gap), 1U);
}

TEST_F(TimingStatisticsTest, WhatHasExplainedAGapIsNotLeftOver) {
  for (int k = 1; k <= 2; ++k) {
    statistics->add(overrun_at(k * 100 * ms - 10 * ms, 50 * ms, gap_of(50 * ms, GapPlace::read), true));
    statistics->add(SchedulerSample{
        .t_ns = k * 100 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  }
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);
  EXPECT_EQ(count(OverrunCause::stage_gap), 1U);
}

// What a long stop skips lies before the deadline that is served: the miss was over at 100 ms.
TEST_F(TimingStatisticsTest, AnOverrunIsOverWhenTheThreadWokeUp) {
  statistics->add(overrun_at(100 * ms, 50 * ms, gap_of(50 * ms, GapPlace::read), true));
  statistics->add(
      SchedulerSample{.t_ns = 101 * ms, .run_delay_ns = 50 * ms, .involuntary_switches = 1, .valid = true});
  ASSERT_EQ(count(OverrunCause::machine_gap), 1U);
  EXPECT_EQ(statistics->worst().front().t_ns, 50 * ms) << "the deadline that was missed";
}

TEST_F(TimingStatisticsTest, LongWorkWithoutAGapIsOursWhateverTheMachineDid) {
  statistics->add(overrun_at(10 * ms, 300'000, {}, true));
  statistics->add(SchedulerSample{.t_ns = 40 * ms,
                                  .run_delay_ns = 40 * ms,
                                  .steal_ns = 40 * ms,
                                  .involuntary_switches = 40,
                                  .valid = true});
  EXPECT_EQ(count(OverrunCause::long_execution), 1U);
  EXPECT_EQ(count(OverrunCause::machine_gap), 0U);
  EXPECT_EQ(statistics->without_gap(), 1U);
}

TEST_F(TimingStatisticsTest, OneTheftExplainsOneGap) {
  for (int k = 0; k < 3; ++k)
    statistics->add(overrun_at(k * ms, 300'000, gap_of(6 * ms, GapPlace::drive), true));
  statistics->add(SchedulerSample{.t_ns = 40 * ms, .steal_ns = 10 * ms, .valid = true});
  EXPECT_EQ(count(OverrunCause::machine_gap), 1U);
  EXPECT_EQ(count(OverrunCause::stage_gap), 2U);
}

TEST_F(TimingStatisticsTest, WithoutTheKernelsWordTheStampsDecideAfterASecond) {
  statistics->add(overrun_at(0, 300'000, gap_of(400'000, GapPlace::read), true));
  statistics->add(overrun_at(999 * ms, 300'000, gap_of(400'000, GapPlace::read), true));
  EXPECT_EQ(counted(), 0U);
  statistics->add(overrun_at(1'000 * ms, 300'000, gap_of(400'000, GapPlace::read), true));
  EXPECT_EQ(count(OverrunCause::stage_gap), 1U);
  for (int k = 0; k < 5'000; ++k)
    statistics->add(overrun_at(1'000 * ms + k, 300'000, gap_of(400'000, GapPlace::read), true));
  EXPECT_EQ(count(OverrunCause::stage_gap), 3U + 5'000U - 1'024U) << "so many wait, and no more";
}

TEST_F(TimingStatisticsTest, WhatNoSampleExplainedIsCountedAtTheEnd) {
  statistics->add(overrun_at(10 * ms, 300'000, gap_of(400'000, GapPlace::drive), true));
  statistics->add(overrun_at(11 * ms, 300'000, {}, true));
  EXPECT_EQ(count(OverrunCause::stage_gap), 0U);
  statistics->finish();
  EXPECT_EQ(count(OverrunCause::stage_gap), 1U);
  EXPECT_EQ(count(OverrunCause::long_execution), 1U);
  statistics->finish();
  EXPECT_EQ(counted(), 2U);
}

TEST_F(TimingStatisticsTest, TheLatestWakeUpsAreKeptTheLatestFirst) {
  for (int k = 1; k <= 50; ++k) {
    statistics->add(
        overrun_at(k * ms, (k * 37 % 50 + 1) * 1'000'000, gap_of(20'000'000, GapPlace::waiting), false));
  }
  ASSERT_EQ(statistics->worst().size(), TimingStatistics::worst_kept);
  for (std::size_t i = 0; i < TimingStatistics::worst_kept; ++i) {
    EXPECT_EQ(statistics->worst()[i].latency_ns, (50 - std::int64_t(i)) * ms);
  }
}

TEST_F(TimingStatisticsTest, AnIntervalIsForgottenAndTheRunIsNot) {
  statistics->add(WakeRecord{.latency_ns = 5, .execution_ns = 7, .longest_gap_ns = 11});
  statistics->add(StageRecord{1, 2, 3, 4, 5});
  EXPECT_EQ(statistics->interval().stages[4].max_ns(), 5);
  statistics->reset_interval();
  EXPECT_EQ(statistics->interval().execution.count(), 0U);
  EXPECT_EQ(statistics->interval().longest_gap_ns, 0);
  EXPECT_EQ(statistics->total().latency.max_ns(), 5);
  EXPECT_EQ(statistics->total().execution.max_ns(), 7);
  EXPECT_EQ(statistics->total().longest_gap_ns, 11);
  for (std::size_t i = 0; i < stage_count; ++i) {
    EXPECT_EQ(statistics->total().stages[i].max_ns(), std::int64_t(i) + 1);
  }
}

std::string report(const TimingStatistics& statistics) {
  std::FILE* const file = std::tmpfile();
  print_timing(file, statistics);
  std::string text(static_cast<std::size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), file), text.size());
  std::fclose(file);
  return text;
}

TEST_F(TimingStatisticsTest, TheReportNamesStagesCausesAndTheWorst) {
  EXPECT_THAT(report(*statistics), Not(HasSubstr("without a gap")));
  WakeRecord overrun = overrun_at(1'500 * ms, 300'000, gap_of(400'000, GapPlace::waiting), false);
  overrun.periods = 9;
  overrun.periods_missed = 3;
  overrun.overruns = 1;
  statistics->add(overrun);
  statistics->add(StageRecord{1'000, 2'000, 3'000, 4'000, 5'000});
  statistics->add(
      SchedulerSample{.t_ns = 2'000 * ms, .involuntary_switches = 6, .minor_faults = 7, .valid = true});
  const std::string text = report(*statistics);
  EXPECT_THAT(text, HasSubstr("control periods 9 run, 3 missed in 1 overruns"));
  EXPECT_THAT(text, HasSubstr("machine gap        1\n"));
  EXPECT_THAT(text, HasSubstr("without a gap      0\n"));
  EXPECT_THAT(text, HasSubstr("at 1.499750 s: 300.0 us late, gap of 400.0 us, while waiting: machine gap\n"));
  EXPECT_THAT(text, HasSubstr("7 page faults"));
  EXPECT_THAT(text, HasSubstr("6 involuntary switches"));
  for (const char* const stage : {"read", "commands", "drive", "write", "push"})
    EXPECT_THAT(text, HasSubstr(stage));
}

}  // namespace
}  // namespace sextant::ecu
