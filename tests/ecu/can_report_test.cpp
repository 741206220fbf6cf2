#include "ecu/tasks/can_report.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(CanReport, TellsTheWorstOfEachSecondOnce) {
  SharedState shared{25'000, 1};
  CanReport report{shared};
  report.start(0);
  report.add({.deadline_ns = 999 * ms, .latency_ns = 7, .execution_ns = 5, .periods_missed = 2});
  EXPECT_FALSE(shared.real_time.update()) << "the second is not over";
  report.add({.deadline_ns = 1000 * ms, .latency_ns = 6, .execution_ns = 8, .periods_missed = 3});
  ASSERT_TRUE(shared.real_time.update());
  EXPECT_DOUBLE_EQ(shared.real_time.value().worst_wake_latency, 7e-9);
  EXPECT_DOUBLE_EQ(shared.real_time.value().worst_execution_time, 8e-9);
  EXPECT_EQ(shared.real_time.value().periods_missed, 3U);
  report.add({.deadline_ns = 1999 * ms, .latency_ns = 1, .execution_ns = 1, .periods_missed = 3});
  EXPECT_FALSE(shared.real_time.update());
  report.add({.deadline_ns = 2000 * ms, .latency_ns = 2, .execution_ns = 1, .periods_missed = 4});
  ASSERT_TRUE(shared.real_time.update());
  EXPECT_DOUBLE_EQ(shared.real_time.value().worst_wake_latency, 2e-9) << "the second before is forgotten";
}

TEST(CanReport, TellsWhatIsLeftAtTheEnd) {
  SharedState shared{1'000'000, 1};
  CanReport report{shared};
  report.start(0);
  const WakeRecord last{.deadline_ns = ms, .latency_ns = 4, .execution_ns = 3, .periods_missed = 1};
  report.add(last);
  for (std::size_t n = 0; n < 5'000; ++n) shared.telemetry.push({});
  shared.unpublished_periods.store(400);
  report.hand_over(last);
  EXPECT_DOUBLE_EQ(shared.real_time.latest().worst_wake_latency, 4e-9);
  EXPECT_DOUBLE_EQ(shared.real_time.value().worst_execution_time, 3e-9);
  EXPECT_EQ(shared.real_time.value().telemetry_dropped, shared.telemetry.dropped() + 400)
      << "lost to the ring and to the publisher";
  EXPECT_GT(shared.telemetry.dropped(), 0U);
}

}  // namespace
}  // namespace sextant::ecu
