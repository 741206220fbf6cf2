#include "ecu/tasks/thread_watch.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

using Change = ThreadWatch::Change;

class ThreadWatchTest : public testing::TestWithParam<int> {
 protected:
  int timeout_steps{ThreadWatch::timeout_ms / GetParam()};
  ThreadWatch watch{GetParam()};
};

TEST_P(ThreadWatchTest, AThreadThatStopsAndResumesIsReportedOnceEach) {
  for (int k = 0; k < 10'000; ++k) EXPECT_EQ(watch.step(0), Change::none) << "it has not started";
  std::uint64_t polls = 1;
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(watch.step(polls++), Change::none);
  const std::uint64_t last = polls - 1;
  for (int k = 1; k < timeout_steps; ++k) EXPECT_EQ(watch.step(last), Change::none) << k;
  EXPECT_EQ(watch.step(last), Change::stopped);
  for (int k = 0; k < 10'000; ++k) EXPECT_EQ(watch.step(last), Change::none);
  EXPECT_EQ(watch.step(last + 1), Change::resumed);
  EXPECT_EQ(watch.step(last + 2), Change::none);
}

TEST_P(ThreadWatchTest, APollInTimeStartsTheTimeAgain) {
  std::uint64_t polls = 1;
  for (int k = 0; k < 10; ++k) {
    ++polls;
    for (int n = 1; n < timeout_steps; ++n) EXPECT_EQ(watch.step(polls), Change::none);
  }
}

INSTANTIATE_TEST_SUITE_P(StepsOf, ThreadWatchTest, testing::Values(1, 10));

}  // namespace
}  // namespace sextant::ecu
