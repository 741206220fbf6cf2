#include "ecu/threads/telemetry_watch.hpp"

#include <gtest/gtest.h>

namespace sextant::ecu {
namespace {

using Change = TelemetryWatch::Change;

TEST(TelemetryWatch, AThreadThatStopsAndResumesIsReportedOnceEach) {
  TelemetryWatch watch;
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(watch.step(0), Change::none) << "it has not started";
  std::uint64_t polls = 1;
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(watch.step(polls++), Change::none);
  const std::uint64_t last = polls - 1;
  for (int k = 1; k < TelemetryWatch::timeout_steps; ++k) EXPECT_EQ(watch.step(last), Change::none) << k;
  EXPECT_EQ(watch.step(last), Change::stopped);
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(watch.step(last), Change::none);
  EXPECT_EQ(watch.step(last + 1), Change::resumed);
  EXPECT_EQ(watch.step(last + 2), Change::none);
}

TEST(TelemetryWatch, APollInTimeStartsTheTimeAgain) {
  TelemetryWatch watch;
  std::uint64_t polls = 1;
  for (int k = 0; k < 10; ++k) {
    ++polls;
    for (int n = 1; n < TelemetryWatch::timeout_steps; ++n) EXPECT_EQ(watch.step(polls), Change::none);
  }
}

}  // namespace
}  // namespace sextant::ecu
