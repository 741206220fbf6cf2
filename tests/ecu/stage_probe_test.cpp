#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "ecu/timing/stamped_cycle.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t busy_ns = 300'000;
constexpr std::int64_t limit_ns = 10'000;

void work(std::int64_t duration_ns) {
  for (const std::int64_t begin_ns = now_ns(); now_ns() - begin_ns < duration_ns;) {
  }
}

/// Takes its time in one of its calls.
class SlowIo final : public DriveIo<double> {
 public:
  std::int64_t read_ns{0};
  std::int64_t write_ns{0};
  [[nodiscard]] Measurement<double> read(std::int64_t /*t_ns*/) noexcept override {
    work(read_ns);
    return {};
  }
  void write(const GatePattern&) noexcept override { work(write_ns); }
};

struct SlowCommands {
  std::int64_t latest_ns{0};
  DriveRequest<double> latest(std::int64_t) noexcept {
    work(latest_ns);
    return {};
  }
};

struct SlowSink {
  std::int64_t push_ns{0};
  void push(const Telemetry<double>&) noexcept { work(push_ns); }
};

/// One period with each stage at its place; `drive_ns` is the time of the drive.
struct Period {
  StageProbe probe{true, limit_ns};
  SlowIo slow_io{};
  SlowCommands slow_commands{};
  SlowSink slow_sink{};
  Ring<StageRecord> records{4};
  CommandProbe command_probe{};
  StampedIo io{slow_io, probe, command_probe};
  StampedCommands<SlowCommands> commands{slow_commands, probe, command_probe};
  StampedTelemetry<SlowSink> sink{slow_sink, probe, records};

  StageRecord run(std::int64_t drive_ns = 0) {
    probe.wake();
    (void)io.read(1);
    (void)commands.latest(1);
    work(drive_ns);
    io.write({});
    sink.push({});
    StageRecord record{};
    EXPECT_TRUE(records.pop(record));
    return record;
  }
};

TEST(StageProbe, TheTimeOfAStageIsCountedAsThatStages) {
  for (std::size_t slow = 0; slow < stage_count; ++slow) {
    SCOPED_TRACE(to_string(static_cast<Stage>(slow)));
    Period period;
    std::int64_t drive_ns = 0;
    std::array<std::int64_t*, stage_count> times{&period.slow_io.read_ns, &period.slow_commands.latest_ns,
                                                 &drive_ns, &period.slow_io.write_ns,
                                                 &period.slow_sink.push_ns};
    *times[slow] = busy_ns;
    const std::int64_t begin_ns = now_ns();
    const StageRecord record = period.run(drive_ns);
    const auto all_ns = double(now_ns() - begin_ns);
    // The counter's scale is good to a thousandth. Counted there, and nowhere a second time, however long the
    // machine keeps the thread from running.
    EXPECT_GE(record[slow], std::uint32_t(0.998 * busy_ns));
    EXPECT_LE(std::accumulate(record.begin(), record.end(), 0.0), 1.002 * all_ns);
    // The longest of them is the gap, unless the machine stopped between two stages for longer.
    const auto longest = std::ranges::max_element(record);
    const Gap gap = period.probe.gap();
    EXPECT_GE(gap.longest_ns, *longest);
    if (gap.longest_ns == *longest) {
      EXPECT_EQ(gap.place, static_cast<GapPlace>(longest - record.begin()));
    } else {
      EXPECT_EQ(gap.place, GapPlace::between);
    }
  }
}

TEST(StageProbe, WhatLiesBetweenTheStagesIsSeenAsAGap) {
  // A machine that stops within the stage for longer makes that the longest; not every time.
  bool between = false;
  for (int i = 0; i < 100 && !between; ++i) {
    Period period;
    period.probe.wake();
    work(busy_ns);
    (void)period.io.read(1);
    EXPECT_GE(period.probe.gap().longest_ns, std::int64_t(0.998 * busy_ns));
    between = period.probe.gap().place == GapPlace::between;
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

TEST(StageProbe, OneThatIsOffRecordsNothing) {
  StageProbe probe{false, limit_ns};
  SlowIo slow;
  slow.read_ns = busy_ns;
  CommandProbe command_probe;
  StampedIo io{slow, probe, command_probe};
  SlowSink slow_sink;
  Ring<StageRecord> records{4};
  StampedTelemetry<SlowSink> sink{slow_sink, probe, records};
  probe.wake();
  (void)io.read(1);
  sink.push({});
  probe.finish(busy_ns);
  StageRecord record{};
  EXPECT_FALSE(records.pop(record));
  EXPECT_EQ(probe.gap().longest_ns, 0);
}

}  // namespace
}  // namespace sextant::ecu
