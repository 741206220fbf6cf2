#include "ecu/telemetry/publisher_watch.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// Steps every `every_ns` until the watch reports a stop or `steps` have passed; the steps taken.
int steps_until_stopped(PublisherWatch& watch, std::int64_t& t_ns, std::int64_t every_ns, int steps) {
  for (int k = 1; k <= steps; ++k) {
    t_ns += every_ns;
    if (watch.step(t_ns)) return k;
  }
  return steps;
}

TEST(PublisherWatch, AProcessThatReportsRunsForEver) {
  PublisherWatch watch;
  for (std::int64_t t = 5 * ms; t < 100'000 * ms; t += ms) {
    if (t % publisher_reports_every_ns == 0) watch.heard();
    ASSERT_FALSE(watch.step(t)) << t;
  }
}

TEST(PublisherWatch, AProcessThatNoLongerReportsHasStoppedAfterTwentyIntervals) {
  for (const std::int64_t every_ns : {ms, 7 * ms, 99 * ms}) {
    SCOPED_TRACE(every_ns);
    PublisherWatch watch;
    std::int64_t t = 1000 * ms;
    watch.heard();
    EXPECT_FALSE(watch.step(t));
    const std::int64_t begin = t;
    (void)steps_until_stopped(watch, t, every_ns, 100'000);
    EXPECT_GT(t - begin, PublisherWatch::timeout_ns);
    EXPECT_LE(t - begin, PublisherWatch::timeout_ns + every_ns);
    EXPECT_TRUE(watch.step(t)) << "it stays stopped";
    watch.heard();
    EXPECT_FALSE(watch.step(t + ms)) << "until a message comes";
  }
}

TEST(PublisherWatch, AStopOfTheWholeMachineIsOneInterval) {
  PublisherWatch watch;
  watch.heard();
  std::int64_t t = 0;
  EXPECT_FALSE(watch.step(t));
  // Each time one stop of an hour, and then a report: the process was stopped with the drive.
  for (int k = 0; k < 100; ++k) {
    t += 3'600'000 * ms;
    EXPECT_FALSE(watch.step(t));
    watch.heard();
  }
  EXPECT_EQ(steps_until_stopped(watch, t, 3'600'000 * ms, 100), 21) << "one that never reports is found";
  t -= 10 * ms;
  EXPECT_TRUE(watch.step(t)) << "a clock that goes back takes nothing away";
}

TEST(PublisherWatch, ANewProcessHasTheTimeOfItsStart) {
  PublisherWatch watch;
  watch.heard();
  std::int64_t t = 0;
  (void)watch.step(t);
  (void)steps_until_stopped(watch, t, ms, 100'000);
  watch.start();
  EXPECT_FALSE(watch.step(t));
  const std::int64_t begin = t;
  (void)steps_until_stopped(watch, t, ms, 100'000);
  EXPECT_EQ(t - begin, PublisherWatch::start_timeout_ns + ms);
}

}  // namespace
}  // namespace sextant::ecu
