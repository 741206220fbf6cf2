#include "sextant/realtime/cycle_counter.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(CycleCounter, AgreesWithTheClock) {
  const CycleCounter counter;
  const std::int64_t outer_begin_ns = now_ns();
  const std::uint64_t begin = counter.ticks();
  const std::int64_t inner_begin_ns = now_ns();
  std::this_thread::sleep_for(std::chrono::milliseconds{50});
  const std::int64_t inner_end_ns = now_ns();
  const std::uint64_t end = counter.ticks();
  const std::int64_t outer_end_ns = now_ns();
  const double measured_ns = double(counter.to_ns(end - begin));
  EXPECT_GE(measured_ns, 0.999 * double(inner_end_ns - inner_begin_ns));
  EXPECT_LE(measured_ns, 1.001 * double(outer_end_ns - outer_begin_ns));
}

TEST(CycleCounter, NeverRunsBackwards) {
  const CycleCounter counter;
  std::uint64_t last = counter.ticks();
  for (int i = 0; i < 1'000'000; ++i) {
    const std::uint64_t now = counter.ticks();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(CycleCounter, ACounterThatSteppedBackCountsAsNoTime) {
  const CycleCounter counter;
  EXPECT_EQ(counter.elapsed_ns(1'000'000, 999'999), 0);
  EXPECT_EQ(counter.elapsed_ns(1'000'000, 2'000'000), counter.to_ns(1'000'000));
}

}  // namespace
}  // namespace sextant
