#include "ecu/can_report.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(CanReport, TellsTheWorstOfEachSecondOnce) {
  Crossings crossings{25'000, 1};
  CanReport report{crossings};
  report.start(0);
  report.add({.deadline_ns = 999 * ms, .latency_ns = 7, .body_ns = 5, .periods_skipped = 2});
  EXPECT_FALSE(crossings.statistics.update()) << "the second is not over";
  report.add({.deadline_ns = 1000 * ms, .latency_ns = 6, .body_ns = 8, .periods_skipped = 3});
  ASSERT_TRUE(crossings.statistics.update());
  EXPECT_EQ(crossings.statistics.value().worst_latency_ns, 7);
  EXPECT_EQ(crossings.statistics.value().worst_body_ns, 8);
  EXPECT_EQ(crossings.statistics.value().periods_skipped, 3U);
  report.add({.deadline_ns = 1999 * ms, .latency_ns = 1, .body_ns = 1, .periods_skipped = 3});
  EXPECT_FALSE(crossings.statistics.update());
  report.add({.deadline_ns = 2000 * ms, .latency_ns = 2, .body_ns = 1, .periods_skipped = 4});
  ASSERT_TRUE(crossings.statistics.update());
  EXPECT_EQ(crossings.statistics.value().worst_latency_ns, 2) << "the second before is forgotten";
}

TEST(CanReport, TellsWhatIsLeftAtTheEnd) {
  Crossings crossings{1'000'000, 1};
  CanReport report{crossings};
  report.start(0);
  const WakeRecord last{.deadline_ns = ms, .latency_ns = 4, .body_ns = 3, .periods_skipped = 1};
  report.add(last);
  for (std::size_t n = 0; n < 5'000; ++n) crossings.telemetry.push({});
  report.hand_over(last);
  EXPECT_EQ(crossings.statistics.latest().worst_latency_ns, 4);
  EXPECT_EQ(crossings.statistics.value().worst_body_ns, 3);
  EXPECT_EQ(crossings.statistics.value().telemetry_dropped, crossings.telemetry.dropped());
  EXPECT_GT(crossings.telemetry.dropped(), 0U);
}

}  // namespace
}  // namespace sextant::ecu
