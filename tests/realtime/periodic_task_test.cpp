#include "sextant/realtime/periodic_task.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(PeriodicTask, NeverWakesBeforeADeadlineAndStaysOnTheGrid) {
  const WakeSchedule::Parameters parameters{50'000, 4};
  PeriodicTask task{parameters};
  const std::int64_t origin_ns = task.start();
  for (int i = 0; i < 50; ++i) {
    const WakeSchedule::Wake wake = task.wait();
    EXPECT_GE(now_ns(), wake.deadline_ns);
    EXPECT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
  }
}

TEST(PeriodicTask, AStallIsOneOverrunAndIsSkippedOver) {
  const WakeSchedule::Parameters parameters{50'000, 2};
  PeriodicTask task{parameters};
  const std::int64_t origin_ns = task.start();
  task.wait();
  const std::uint64_t overruns_before = task.schedule().counters().overruns;
  std::this_thread::sleep_for(std::chrono::milliseconds{2});
  const WakeSchedule::Wake wake = task.wait();
  EXPECT_TRUE(wake.overrun());
  EXPECT_GE(wake.periods_skipped, 38) << "2 ms are twenty wake periods, at least the last of which is served";
  EXPECT_EQ(task.schedule().counters().overruns, overruns_before + 1);
  EXPECT_EQ((wake.deadline_ns - origin_ns) % parameters.wake_period_ns(), 0);
}

}  // namespace
}  // namespace sextant
