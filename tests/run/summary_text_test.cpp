#include "sextant/run/summary_text.hpp"

#include <cstdint>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;  // [ns]

RunSummary balanced() {
  RunSummary s{.scenario = "x"};
  s.metrics[Metric::energy_unaccounted] = 0;
  return s;
}

TEST(SummaryText, LimitsValuesAndWindows) {
  EXPECT_EQ(limit_text({"m", {}, 14.0}), "≤ 14");
  EXPECT_EQ(limit_text({"m", 2.5, {}}), "≥ 2.5");
  EXPECT_EQ(limit_text({"m", -3.0, 1.0}), "-3 … 1");
  EXPECT_EQ(limit_text({"m", {}, {}}), "");
  EXPECT_EQ(value_text(12.345678), "12.346");
  EXPECT_EQ(value_text(std::numeric_limits<double>::quiet_NaN()), "-");
  EXPECT_EQ(window_text({200 * ms, 500 * ms}), "0.2 s to 0.5 s");
  EXPECT_EQ(window_text({.from_ns = 200 * ms}), "0.2 s to the end");
  EXPECT_EQ(unit_text("torque_bias_nm"), "N·m");
  EXPECT_EQ(unit_text("no_metric"), "");
}

TEST(SummaryText, LimitsAndWindowsThatDifferHaveTextsThatDiffer) {
  EXPECT_EQ(limit_text({"m", 0.3000001, 1234567.5}), "0.3000001 … 1234567.5");
  EXPECT_EQ(window_text({300'000'100, 123'456'789'012}), "0.3000001 s to 123.456789012 s");
}

TEST(SummaryText, NothingIsToBeSaidOfARunThatPassesOrMissesALimit) {
  EXPECT_EQ(reason_text(balanced()), "");
  RunSummary s = balanced();
  s.expectations = {{.limit = {"torque_bias_nm", {}, 1.0}, .value = 2, .pass = false}};
  EXPECT_EQ(s.verdict(), Verdict::fail);
  EXPECT_EQ(reason_text(s), "");
}

TEST(SummaryText, TheReasonOfAVerdict) {
  RunSummary tripped = balanced();
  tripped.faults = {{Fault::over_current, 1500 * ms}};
  EXPECT_EQ(reason_text(tripped),
            "the drive tripped with OVER_CURRENT at 1.500000 s; see [protection] and [command]");

  RunSummary unbalanced;
  unbalanced.metrics[Metric::energy_unaccounted] = 0.012;
  EXPECT_THAT(reason_text(unbalanced), testing::StartsWith("0.012 of the energy is unaccounted for, "));

  RunSummary interrupted = balanced();
  interrupted.stopped = true;
  interrupted.metrics[Metric::simulated] = 0.25;
  EXPECT_EQ(reason_text(interrupted), "interrupted at 0.250000 s");

  RunSummary still = balanced();
  still.missing_torque = MissingTorque{.asked = 632, .made = 0.25, .state = DriveState::magnetising};
  EXPECT_EQ(reason_text(still),
            "torque was asked, 632 N·m in the mean, and 0.25 N·m were made; the drive was in MAGNETISING at "
            "last");

  RunSummary behind = balanced();
  behind.cycle_departure = CycleDeparture{.from_ns = 7400 * ms, .duration_ns = 15'200 * ms, .farthest = 5};
  EXPECT_EQ(reason_text(behind),
            "the vehicle was up to 18 km/h off its cycle, for 15.2 s from 7.4 s on; see [driver] and the "
            "torque that the drive has");

  RunSummary silent = balanced();
  silent.expectations_required = true;
  EXPECT_THAT(reason_text(silent), testing::StartsWith("nothing is expected of the run"));

  RunSummary missing = balanced();
  missing.expected_fault = FaultExpectation{.fault = Fault::command_lost};
  EXPECT_EQ(reason_text(missing), "COMMAND_LOST was expected and did not come");

  RunSummary cut = balanced();
  cut.trace_error = "trace.h5: recording stopped";
  EXPECT_EQ(reason_text(cut), "trace.h5: recording stopped");
}

TEST(SummaryText, AProblemComesFirstAndEachSentenceHasALine) {
  RunSummary s = balanced();
  s.problem = "the integrator of the plant failed";
  EXPECT_EQ(reason_text(s), "the integrator of the plant failed");
  s.stopped = true;
  s.metrics[Metric::simulated] = 1;
  EXPECT_EQ(reason_text(s), "the integrator of the plant failed\ninterrupted at 1.000000 s");
  s.trace_error = "trace.h5: recording stopped";
  EXPECT_EQ(reason_text(s),
            "the integrator of the plant failed\ninterrupted at 1.000000 s\ntrace.h5: recording stopped");
}

}  // namespace
}  // namespace sextant
