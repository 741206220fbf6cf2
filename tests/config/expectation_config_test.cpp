// What a scenario expects of its run, and what it must not ask of its drive.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string head =
    "name = \"x\"\nduration_s = 2\nmachine = \"" SEXTANT_SOURCE_DIR "/configs/machines/paper_3hp.toml\"\n";

class ExpectationConfig : public ::testing::Test {
 protected:
  ScenarioConfig load(const std::string& text, const std::vector<std::string>& overrides = {}) {
    file_ = files_.write("scenario.toml", head + text);
    return load_scenario_config(file_, overrides);
  }
  /// Why it is refused.
  std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
      (void)load(text, overrides);
    } catch (const ConfigError& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }
  ConfigFiles files_{};
  std::string file_{};
};

const std::string two_windows = R"(
[profile.torque_nm]
value = 15
[[expect.window]]
from_s = 0.5
to_s = 1
torque_bias_nm = { min = -2, max = 1 }
[[expect.window]]
from_s = 1.5
flux_mean_wb.max = 1.2
)";

TEST_F(ExpectationConfig, WindowsHaveLimitsOfTheirOwn) {
  const ScenarioConfig c = load(two_windows);
  ASSERT_EQ(c.scenario.windows.size(), 2U);
  const WindowExpectation& first = c.scenario.windows[0];
  EXPECT_EQ(first.window.from_ns, 500'000'000);
  EXPECT_EQ(first.window.to_ns, 1'000'000'000);
  ASSERT_EQ(first.limits.size(), 1U);
  EXPECT_EQ(first.limits[0].metric, "torque_bias_nm");
  EXPECT_EQ(first.limits[0].min, -2);
  EXPECT_EQ(first.limits[0].max, 1);
  const WindowExpectation& second = c.scenario.windows[1];
  EXPECT_EQ(second.window.to_ns, TimeWindow{}.to_ns);
  EXPECT_EQ(second.limits.at(0).metric, "flux_mean_wb");
  EXPECT_TRUE(c.scenario.expectations.empty());
}

TEST_F(ExpectationConfig, WindowsSurviveTheRoundTrip) {
  const std::string printed = print_config(load(two_windows));
  EXPECT_EQ(print_config(load_scenario_config(files_.write("printed.toml", printed))), printed);
  EXPECT_THAT(printed, HasSubstr("[[expect.window]]"));
  EXPECT_THAT(printed, HasSubstr("[expect.window.torque_bias_nm]"));
}

TEST_F(ExpectationConfig, WrongWindowsAreRefusedWithFileLineAndKey) {
  EXPECT_THAT(refusal("[[expect.window]]\nfrom_s = 0.5\nto_s = \"late\"\n"),
              HasSubstr(file_ + ":6: expect.window[0].to_s: expected a number"));
  EXPECT_THAT(refusal("[[expect.window]]\ntorque_bias = { max = 1 }\n"),
              HasSubstr("expect.window[0].torque_bias: unknown key; the nearest known one is "
                        "expect.window[0].torque_bias_nm"));
  EXPECT_THAT(refusal("[[expect.window]]\nfrom_s = 0.5\n"), HasSubstr("the window has no limit"));
  EXPECT_THAT(refusal("[[expect.window]]\nfrom_s = 1\nto_s = 0.5\nflux_mean_wb.max = 1\n"),
              HasSubstr("the window must end after it begins"));
  EXPECT_THAT(refusal("[[expect.window]]\nfrom_s = 3\nflux_mean_wb.max = 1\n"),
              HasSubstr("begins after the run"));
  EXPECT_THAT(refusal("[expect]\nwindow = 3\n"),
              HasSubstr("expect.window: expected a list of tables, got 3"));
}

TEST_F(ExpectationConfig, AFaultIsExpectedByItsName) {
  EXPECT_FALSE(load("").scenario.expected_fault);
  const ScenarioConfig c = load("[expect]\nfault = \"OVER_CURRENT\"\nfault_from_s = 0.1\nfault_to_s = 0.2\n");
  ASSERT_TRUE(c.scenario.expected_fault);
  EXPECT_EQ(c.scenario.expected_fault->fault, Fault::over_current);
  EXPECT_EQ(c.scenario.expected_fault->window.from_ns, 100'000'000);
  EXPECT_EQ(c.scenario.expected_fault->window.to_ns, 200'000'000);
  EXPECT_THAT(refusal("[expect]\nfault = \"OVERCURRENT\"\n"), HasSubstr(":5: expect.fault: expected "));
  EXPECT_THAT(refusal("[expect]\nfault_to_s = 1\n"), HasSubstr("need a fault"));
}

TEST_F(ExpectationConfig, ALinkAboveItsOwnTripLevelIsRefused) {
  EXPECT_THAT(refusal("[protection]\ndc_over_voltage_v = 500\n[plant]\nu_dc_v = 530\n"),
              HasSubstr(file_ + ":7: plant.u_dc_v: 530 V is above protection.dc_over_voltage_v, 500 V"));
  EXPECT_NO_THROW(load("[protection]\ndc_over_voltage_v = 530\n[plant]\nu_dc_v = 530\n"));
  EXPECT_NO_THROW(
      load("[protection]\ndc_over_voltage_v = 500\n[plant]\nu_dc_v = 530\n[expect]\nfault = "
           "\"DC_OVER_VOLTAGE\"\n"))
      << "the trip is what the scenario shows";
  EXPECT_THROW((void)load_ecu_config(shipped_ecu, {"protection.dc_over_voltage_v=500"}), ConfigError);
}

TEST_F(ExpectationConfig, AnImposedSpeedAboveItsOwnTripLevelIsRefused) {
  const std::string level =
      "[protection]\nover_speed_rad_s = 200\n[load]\nkind = \"imposed_speed\"\n[load.speed_rad_s]\n";
  EXPECT_THAT(refusal(level + "value = -200.5\n"),
              HasSubstr(file_ + ":8: load.speed_rad_s: the speed reaches 200.5 rad/s, above "
                                "protection.over_speed_rad_s, 200 rad/s"));
  EXPECT_NO_THROW(load(level + "value = 200\n"));
  const std::string ramp = level + "shape = \"linear\"\npoints = [[0, 0], [4, 400]]\n";
  EXPECT_NO_THROW(load(ramp)) << "the run ends before";
  EXPECT_THAT(refusal(ramp, {"duration_s=2.5"}), HasSubstr("reaches 250 rad/s"));
  EXPECT_NO_THROW(load(level + "value = 300\n[expect]\nfault = \"OVER_SPEED\"\n"));
  const std::vector<std::string> live{"load.kind=imposed_speed", "load.speed_rad_s.value=300"};
  EXPECT_NO_THROW((void)load_ecu_config(shipped_ecu, live));
  std::vector<std::string> fast = live;
  fast.emplace_back("protection.over_speed_rad_s=299");
  EXPECT_NO_THROW((void)load_ecu_config(shipped_ecu, fast)) << "a live bench may provoke the trip";
}

TEST_F(ExpectationConfig, ACycleFasterThanTheTripLevelIsRefused) {
  const std::string cycle =
      "[cycle]\nfile = \"" SEXTANT_SOURCE_DIR "/configs/cycles/nycc.csv\"\ntable = \"" SEXTANT_SOURCE_DIR
      "/configs/vehicles/passive_ev.csv\"\n";
  EXPECT_NO_THROW(load(cycle, {"duration_s=598"}));
  EXPECT_THAT(refusal(cycle, {"duration_s=598", "protection.over_speed_rad_s=20"}),
              HasSubstr("cycle: the speed reaches "));
}

TEST_F(ExpectationConfig, ASensorThatEndsBelowItsTripLevelIsRefused) {
  const std::string levels =
      "[protection]\nover_current_a = 100\ndc_over_voltage_v = 600\n[plant]\nu_dc_v = 530\n";
  EXPECT_THAT(refusal(levels + "[plant.sensors.current]\nrange_a = 100\n"),
              HasSubstr(file_ + ":10: plant.sensors.current.range_a: readings end at 100 A, not above "
                                "protection.over_current_a, 100 A: OVER_CURRENT could never come"));
  EXPECT_NO_THROW(load(levels + "[plant.sensors.current]\nrange_a = 100.01\n"));
  // Of 8 bits over both signs: a step is 1/128 of the range.
  EXPECT_THAT(refusal(levels + "[plant.sensors.current]\nrange_a = 100.5\nbits = 8\n"),
              HasSubstr("readings end at 99.71 A"));
  EXPECT_NO_THROW(load(levels + "[plant.sensors.current]\nrange_a = 101\nbits = 8\n"));
  EXPECT_THAT(refusal(levels + "[plant.sensors.voltage]\nrange_v = 602\nbits = 8\n"),
              HasSubstr("plant.sensors.voltage.range_v: readings end at 599.6 V"));
  EXPECT_NO_THROW(load(levels + "[plant.sensors.voltage]\nrange_v = 603\nbits = 8\n"));
  EXPECT_NO_THROW(
      load(levels + "[plant.sensors.current]\nrange_a = 50\n[expect]\nfault = \"CURRENT_SUM\"\n"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.sensors.current.range_a=200"}),
              HasSubstr("readings end at 200 A, not above protection.over_current_a, 250 A"));
}

// An edge of 4 N a revolution in a window of k periods of 25 us is a step of 2 pi/(4 N k 25 us).
TEST_F(ExpectationConfig, AnEncoderThatIsTooCoarseForThePeriodIsRefused) {
  const std::string limits = "[protection]\nspeed_jump_rad_s = 50\nspeed_error_rad_s = 40\n";
  const std::string count = "[plant.sensors.encoder]\nspeed = \"count\"\n";
  const std::string period = "[plant.sensors.encoder]\nspeed = \"period\"\n";
  EXPECT_THAT(refusal(limits + count + "lines = 78\nwindow_periods = 40\n"),
              HasSubstr("plant.sensors.encoder.lines: 78 lines make steps of 20.14 rad/s in a window of 40 "
                        "periods, above 20 rad/s (protection.speed_error_rad_s, 40): the drive would trip"));
  EXPECT_NO_THROW(load(limits + count + "lines = 79\nwindow_periods = 40\n"));
  EXPECT_THAT(refusal(limits + count + "lines = 79\nwindow_periods = 39\n"), HasSubstr("39 periods"));
  EXPECT_NO_THROW(load(limits + count + "lines = 40\nwindow_periods = 40\n", {"drive.period_us=50"}));
  EXPECT_THAT(refusal(limits + count + "lines = 100\n", {"protection.speed_jump_rad_s=30"}),
              HasSubstr("above 15 rad/s (protection.speed_jump_rad_s, 30)"));
  EXPECT_THAT(refusal(limits + period + "lines = 39\n"), HasSubstr("above 40 rad/s"));
  EXPECT_NO_THROW(load(limits + period + "lines = 40\n"));
  EXPECT_NO_THROW(load(limits + count + "lines = 8\n[expect]\nfault = \"SPEED_SENSOR\"\n"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.sensors.encoder.lines=16"}), HasSubstr("16 lines make steps"));
}

// Half a step of 4/2^N of each signal, by 0.95307 of 2 pi 300 Hz: 5081/2^N rad/s of the signals.
TEST_F(ExpectationConfig, AResolverThatIsTooCoarseForTheSpeedsChecksIsRefused) {
  const std::string limits = "[protection]\nspeed_jump_rad_s = 50\nspeed_error_rad_s = 40\n";
  const std::string resolver = "[plant.sensors.resolver]\npole_pairs = 1\n";
  EXPECT_THAT(
      refusal(limits + resolver + "bits = 7\n"),
      HasSubstr("plant.sensors.resolver.bits: 7 bits at 300 Hz make errors of the speed of up to 39.7 rad/s, "
                "above 20 rad/s (half of protection.speed_error_rad_s, 40): the drive could trip"));
  EXPECT_NO_THROW(load(limits + resolver + "bits = 8\n"));
  EXPECT_NO_THROW(load(limits + resolver + "bits = 0\n"));
  EXPECT_NO_THROW(load(limits + resolver + "bits = 7\nbandwidth_hz = 151\n"));
  EXPECT_THAT(refusal(limits + resolver + "bits = 7\nbandwidth_hz = 152\n"), HasSubstr("could trip"));
  EXPECT_NO_THROW(load(limits + resolver + "bits = 7\n", {"plant.sensors.resolver.pole_pairs=2"}));
  EXPECT_THAT(refusal(limits + resolver + "bits = 8\n", {"protection.speed_jump_rad_s=30"}),
              HasSubstr("above 15 rad/s (half of protection.speed_jump_rad_s, 30)"));
  EXPECT_NO_THROW(load(limits + resolver + "bits = 4\n[expect]\nfault = \"SPEED_SENSOR\"\n"));
  EXPECT_THAT(
      ecu_refusal(shipped_ecu, {"plant.sensors.resolver.pole_pairs=1", "plant.sensors.resolver.bits=4"}),
      HasSubstr("4 bits at 300 Hz make errors"));
}

// 2 arcsin(2 √2/2^7)/(4 sines · 1 period of 25 us): 442 rad/s, and 20 rad/s in 22 periods.
TEST_F(ExpectationConfig, ASinCosEncoderThatIsTooCoarseForTheSpeedsChecksIsRefused) {
  const std::string limits = "[protection]\nspeed_jump_rad_s = 50\nspeed_error_rad_s = 40\n";
  const std::string encoder = "[plant.sensors.sin_cos]\nperiods = 4\nbits = 7\n";
  EXPECT_THAT(refusal(limits + encoder),
              HasSubstr("plant.sensors.sin_cos.bits: 7 bits of 4 sines a revolution make errors of the speed "
                        "of up to 442 rad/s in a window of 1 periods, above 20 rad/s (half of "
                        "protection.speed_error_rad_s, 40): the drive could trip"));
  EXPECT_THAT(refusal(limits + encoder + "window_periods = 22\n"), HasSubstr("could trip"));
  EXPECT_NO_THROW(load(limits + encoder + "window_periods = 23\n"));
  EXPECT_NO_THROW(load(limits + "[plant.sensors.sin_cos]\nperiods = 4\n"));
  EXPECT_NO_THROW(load(limits + encoder + "[expect]\nfault = \"SPEED_SENSOR\"\n"));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"plant.sensors.sin_cos.periods=1", "plant.sensors.sin_cos.bits=4"}),
              HasSubstr("4 bits of 1 sines"));
}

TEST_F(ExpectationConfig, ATorqueBeyondTheGatesLimitIsRefused) {
  const std::string gate = "[command]\ntorque_limit_nm = 20\n";
  EXPECT_THAT(
      refusal(gate + "[profile.torque_nm]\nvalue = -20.5\n"),
      HasSubstr(
          ":6: profile.torque_nm: the torque reaches 20.5 N·m, beyond command.torque_limit_nm, 20 N·m"));
  EXPECT_THAT(refusal(gate + "[profile.torque_nm]\nshape = \"sine\"\nvalue = 10\namplitude = 10.5\n"),
              HasSubstr("reaches 20.5 N·m"));
  EXPECT_THAT(refusal(gate + "[profile.torque_nm]\nshape = \"steps\"\npoints = [[0, 5], [1, 21]]\n"),
              HasSubstr("reaches 21 N·m"));
  EXPECT_NO_THROW(load(gate + "[profile.torque_nm]\nshape = \"steps\"\npoints = [[0, 5], [3, 21]]\n"))
      << "beyond the end of the run";
  EXPECT_NO_THROW(load(gate + "[profile.torque_nm]\nvalue = 20\n"));
  const std::string event_exact =
      "mode = \"event_exact\"\ncontrol.flux_estimator = \"voltage_model\"\ndrive.magnetise_first = false\n"
      "control.dtc.flux_priority = false\ncontrol.dtc.torque_trim_ms = 0\n";
  EXPECT_NO_THROW(load(event_exact + gate + "[profile.torque_nm]\nvalue = 21\n"))
      << "an event-exact run has no gate";
  EXPECT_NO_THROW(
      load(gate + "[profile.torque_nm]\nvalue = 21\n[expect]\nfault = \"COMMAND_OUT_OF_RANGE\"\n"));
}

TEST_F(ExpectationConfig, TheSignalsOfATraceAreKnownByName) {
  EXPECT_THAT(load("").scenario.trace.signals, ElementsAre("standard"));
  EXPECT_THAT(load("[trace]\nsignals = [\"energy\", \"plant/i_dc_a\"]\n").scenario.trace.signals,
              ElementsAre("energy", "plant/i_dc_a"));
  EXPECT_THAT(load("", {"trace.signals=[\"all\"]"}).scenario.trace.signals, ElementsAre("all"));
  EXPECT_THAT(refusal("[trace]\nsignals = [\"plant/i_dc\"]\n"),
              HasSubstr("there is no \"plant/i_dc\"; the nearest known one is \"plant/i_dc_a\""));
}

TEST_F(ExpectationConfig, TheGroupsOfATraceAreNamedWhereNoneIsGiven) {
  const std::vector<std::string> groups = trace_groups();
  EXPECT_THAT(groups, ::testing::IsSupersetOf({"all", "standard", "driveline", "thermal"}));
  for (const std::string& group : groups)
    EXPECT_THAT(refusal("[trace]\nsignals = []\n"), HasSubstr('"' + group + '"'));
}

}  // namespace
}  // namespace sextant
