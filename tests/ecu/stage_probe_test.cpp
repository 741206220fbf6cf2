#include "ecu/timing/stage_probe.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include <gtest/gtest.h>

#include "ecu/threads/wake_timer.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t busy_ns = 300'000;
constexpr std::int64_t limit_ns = 10'000;

void work(std::int64_t duration_ns) {
  for (const std::int64_t begin_ns = now_ns(); now_ns() - begin_ns < duration_ns;) {
  }
}

/// One period with stages of these times [ns].
StageRecord run(StageProbe& probe, const std::array<std::int64_t, stage_count>& times_ns) {
  probe.wake();
  probe.begin();
  for (std::size_t stage = 0; stage < stage_count; ++stage) {
    work(times_ns[stage]);
    probe.end(static_cast<Stage>(stage));
  }
  return probe.record();
}

/// The same as the probe of `run_cycle`.
StageRecord run(WakeTimer& timer, SharedState& shared,
                const std::array<std::int64_t, stage_count>& times_ns) {
  timer.begins(1);
  work(times_ns[0]);
  timer.has_read({});
  work(times_ns[1]);
  timer.has_request({});
  work(times_ns[2]);
  timer.has_stepped({});
  work(times_ns[3]);
  timer.has_written();
  work(times_ns[4]);
  timer.has_pushed();
  StageRecord record{};
  EXPECT_TRUE(shared.stages.pop(record));
  return record;
}

/// The counter's scale is good to a thousandth. Counted there, and nowhere a second time, however long the
/// machine keeps the thread from running.
void expect_busy(const StageRecord& record, std::size_t stage, std::int64_t all_ns) {
  EXPECT_GE(record[stage], std::uint32_t(0.998 * busy_ns));
  EXPECT_LE(std::accumulate(record.begin(), record.end(), 0.0), 1.002 * double(all_ns));
}

TEST(StageProbe, TheTimeOfAStageIsCountedAsThatStages) {
  for (std::size_t slow = 0; slow < stage_count; ++slow) {
    SCOPED_TRACE(to_string(static_cast<Stage>(slow)));
    StageProbe probe{true, limit_ns};
    std::array<std::int64_t, stage_count> times_ns{};
    times_ns[slow] = busy_ns;
    const std::int64_t begin_ns = now_ns();
    const StageRecord record = run(probe, times_ns);
    expect_busy(record, slow, now_ns() - begin_ns);
    // The longest of them is the gap, unless the machine stopped between two stages for longer.
    const auto longest = std::ranges::max_element(record);
    const Gap gap = probe.gap();
    EXPECT_GE(gap.longest_ns, *longest);
    if (gap.longest_ns == *longest) {
      EXPECT_EQ(gap.place, static_cast<GapPlace>(longest - record.begin()));
    } else {
      EXPECT_EQ(gap.place, GapPlace::between);
    }
  }
}

TEST(WakeTimer, TheTimeOfAStageOfTheCycleIsCountedAsThatStages) {
  for (std::size_t slow = 0; slow < stage_count; ++slow) {
    SCOPED_TRACE(to_string(static_cast<Stage>(slow)));
    SharedState shared{25'000, 1};
    WakeTimer timer{{.wake_every_periods = 1, .gap_limit_ns = limit_ns}, shared};
    std::array<std::int64_t, stage_count> times_ns{};
    times_ns[slow] = busy_ns;
    const std::int64_t begin_ns = now_ns();
    const StageRecord record = run(timer, shared, times_ns);
    expect_busy(record, slow, now_ns() - begin_ns);
  }
}

TEST(WakeTimer, RecordsWhatEntersAndLeavesTheDrive) {
  SharedState shared{25'000, 1};
  CycleRecorder cycles{1};
  WakeTimer timer{{.wake_every_periods = 1}, shared, &cycles};
  timer.begins(75'000);
  timer.has_read({.u_dc = 530.0});
  timer.has_request({.shutdown = true});
  timer.has_stepped({.pattern = {gates_off, 25'000}});
  timer.has_written();
  timer.has_pushed();
  CycleRecord<double> record;
  ASSERT_TRUE(cycles.records().pop(record));
  EXPECT_EQ(record.t_ns, 75'000);
  EXPECT_EQ(record.measurement.u_dc, 530.0);
  EXPECT_TRUE(record.request.shutdown);
  EXPECT_EQ(record.pattern, (GatePattern{gates_off, 25'000}));
}

TEST(StageProbe, WhatLiesBetweenTheStagesIsSeenAsAGap) {
  // A machine that stops within the stage for longer makes that the longest; not every time.
  bool between = false;
  for (int i = 0; i < 100 && !between; ++i) {
    StageProbe probe{true, limit_ns};
    probe.wake();
    work(busy_ns);
    probe.begin();
    probe.end(Stage::read);
    EXPECT_GE(probe.gap().longest_ns, std::int64_t(0.998 * busy_ns));
    between = probe.gap().place == GapPlace::between;
  }
  EXPECT_TRUE(between);
}

TEST(StageProbe, TimeThatNoStampCoversIsAGap) {
  StageProbe probe{true, limit_ns};
  probe.wake();
  probe.finish(busy_ns);
  EXPECT_GT(probe.gap().longest_ns, busy_ns / 2);
  EXPECT_LE(probe.gap().longest_ns, busy_ns);
}

TEST(StageProbe, WhatIsShorterThanTheLimitIsNoGapButTimeAllTheSame) {
  StageProbe probe{true, limit_ns};
  probe.add(limit_ns, GapPlace::between);
  EXPECT_EQ(probe.gap().longest_ns, 0);
  probe.add(limit_ns + 1, GapPlace::waiting);
  probe.add(limit_ns + 2, GapPlace::between);
  EXPECT_EQ(probe.gap().longest_ns, limit_ns + 2);
  EXPECT_EQ(probe.gap().sum_ns, 2 * limit_ns + 3);
  EXPECT_EQ(probe.take_longest_ns(), limit_ns + 2);
  probe.fade_gap(limit_ns);
  EXPECT_EQ(probe.gap().sum_ns, 0);
}

TEST(WakeTimer, WithoutStatisticsOfTheStagesRecordsNone) {
  SharedState shared{25'000, 1};
  WakeTimer timer{{.wake_every_periods = 1, .stage_statistics = false}, shared};
  timer.begins(1);
  timer.has_read({});
  timer.has_pushed();
  StageRecord record{};
  EXPECT_FALSE(shared.stages.pop(record));
}

TEST(StageProbe, OneThatIsOffFindsNoGap) {
  StageProbe probe{false, limit_ns};
  run(probe, {busy_ns});
  probe.finish(busy_ns);
  EXPECT_EQ(probe.gap().longest_ns, 0);
}

}  // namespace
}  // namespace sextant::ecu
