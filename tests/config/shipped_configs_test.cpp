#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

std::string scenario_refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_scenario_config(shipped_scenario, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ShippedConfigs, EveryScenarioLoadsAndExpectsSomething) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator{SEXTANT_SOURCE_DIR "/configs/scenarios"}) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path());
    const ScenarioConfig config = load_scenario_config(entry.path().string());
    EXPECT_EQ(config.scenario.name, entry.path().stem());
    EXPECT_FALSE(config.scenario.description.empty());
    EXPECT_FALSE(config.scenario.expectations.empty());
    ++count;
  }
  EXPECT_GE(count, 2);
}

/// The values, by key, of what makes direct torque control on CVODE hold.
std::vector<std::pair<std::string, std::string>> method(const DriveConfig& c) {
  const DirectTorqueController<>::Parameters& dtc = c.direct_torque();
  const auto text = [](auto value) { return std::to_string(static_cast<double>(value)); };
  return {{"control.controller", c.controller},
          {"plant.integrator", text(c.plant.integrator)},
          {"control.flux_estimator", text(c.control.flux_estimator)},
          {"control.dtc.flux_priority", text(dtc.flux_priority)},
          {"drive.magnetise_first", text(c.drive.magnetise_first)}};
}

TEST(ShippedConfigs, AFileThatLeavesTheMethodOutGetsThatOfTheLiveDrive) {
  const ConfigFiles files;
  const std::string machine = "machine = \"" + shipped_machine + "\"\n";
  const auto live = method(load_ecu_config(shipped_ecu).drive);
  EXPECT_EQ(method(load_ecu_config(files.write("ecu.toml", machine)).drive), live);
  const std::string run = "name = \"test\"\nduration_s = 1\n" + machine;
  EXPECT_EQ(method(load_scenario_config(files.write("scenario.toml", run)).drive), live);
}

TEST(ShippedConfigs, FieldOrientedControlIsOneKeyAway) {
  EXPECT_EQ(print_config(load_ecu_config(SEXTANT_SOURCE_DIR "/configs/ecu_foc.toml")),
            print_config(load_ecu_config(shipped_ecu, {"control.controller=foc"})));
}

TEST(ShippedConfigs, TheLiveDriveRunsThePapersControllerOnCvode) {
  const EcuConfig config = load_ecu_config(shipped_ecu);
  EXPECT_EQ(config.drive.controller, "dtc");
  EXPECT_EQ(config.drive.plant.integrator, IntegratorKind::cvode);
  EXPECT_EQ(config.drive.control.flux_estimator, FluxEstimatorKind::hybrid);
  EXPECT_TRUE(config.drive.direct_torque().flux_priority);
  EXPECT_NEAR(config.drive.direct_torque().torque_trim.time_constant, 0.01, 1e-4) << "by its period";
  EXPECT_TRUE(config.drive.drive.magnetise_first);
  EXPECT_EQ(config.drive.direct_torque().flux_reference, 1.1);
  EXPECT_EQ(config.drive.direct_torque().torque_comparator.upper_band, 0.918);
  EXPECT_EQ(config.drive.plant.io.u_dc, 530.0);
  EXPECT_EQ(config.drive.direct_torque().period_ns, 25'000);
  EXPECT_EQ(config.realtime.wake_every_periods, 40);
  EXPECT_FALSE(config.realtime.required);
  const auto& command = config.drive.drive.command;
  EXPECT_LE(command.timeout_ns + command.zero_ramp_ns, 60'000'000) << "no torque within 60 ms of silence";
}

TEST(ShippedConfigs, TheHardDriveHasBoundedWorkAndInsistsOnItsRights) {
  const EcuConfig config = load_ecu_config(SEXTANT_SOURCE_DIR "/configs/ecu_hard.toml");
  EXPECT_EQ(config.realtime.wake_every_periods, 1) << "a real power stage does not wait";
  EXPECT_TRUE(config.realtime.required);
  EXPECT_TRUE(config.realtime.lock_memory);
  EXPECT_EQ(config.realtime.policy, SchedulingPolicy::fifo);
  EXPECT_NE(config.realtime.wait.mode, WaitMode::sleep);
  EXPECT_EQ(config.drive.plant.integrator, IntegratorKind::fixed);
  EXPECT_EQ(config.drive.drive.period_ns, 250'000);
}

TEST(ShippedConfigs, TheScenarioOfThePaperIsReadWhole) {
  const ScenarioConfig config = load_scenario_config(shipped_scenario);
  const Scenario& s = config.scenario;
  EXPECT_EQ(s.duration_ns, 2'000'000'000);
  EXPECT_EQ(s.torque_reference.shape, ProfileShape::constant);
  EXPECT_EQ(s.torque_reference.value, 15.0);
  EXPECT_EQ(s.load.load_torque.points.size(), 4U);
  EXPECT_FALSE(s.load.imposed_speed.has_value());
  EXPECT_EQ(s.metrics.from_ns, 200'000'000);
  EXPECT_EQ(s.metrics.step_ns, 0);
  EXPECT_EQ(s.metrics.to_ns, MetricsParameters{}.to_ns);
  ASSERT_EQ(s.expectations.size(), 5U);
  EXPECT_EQ(s.expectations[0].metric, "torque_ripple_pp_nm") << "in the order of the catalogue";
  EXPECT_EQ(s.expectations[1].metric, "torque_bias_nm");
  EXPECT_EQ(s.expectations[1].min, -3.0);
  EXPECT_EQ(s.expectations[1].max, 1.0);
  EXPECT_EQ(s.expectations[2].metric, "response_time_ms");
  EXPECT_FALSE(s.expectations[2].min.has_value());
}

TEST(ShippedConfigs, AnImposedSpeedReachesTheLoad) {
  const ScenarioConfig config = load_scenario_config(
      shipped_scenario, {"load={ kind = \"imposed_speed\", speed_rad_s = { value = 10 }, "
                         "torque_nm = { shape = \"constant\", points = [] } }"});
  ASSERT_TRUE(config.scenario.load.imposed_speed.has_value());
  EXPECT_EQ(config.scenario.load.imposed_speed->value, 10.0);
}

TEST(ShippedConfigs, PartsOfARunThatDoNotFitAreRefused) {
  EXPECT_THAT(scenario_refusal({"metrics.window_from_s=3"}), HasSubstr("begins after the run has ended"));
  EXPECT_THAT(scenario_refusal({"metrics.step_s=2"}), HasSubstr("comes after the run has ended"));
  EXPECT_THAT(scenario_refusal({"trace.interval_us=990"}), HasSubstr("whole number of control periods"));
  EXPECT_THAT(scenario_refusal({"trace.interval_us=10"}), HasSubstr("a whole part of one"));
  EXPECT_THAT(scenario_refusal({"trace.interval_us=8.3333333333333333"}),
              HasSubstr("whole number of nanoseconds"));
  EXPECT_EQ(scenario_refusal({"trace.interval_us=2.5"}), "accepted");
  EXPECT_THAT(scenario_refusal({"expect.flux_mean_wb.min=2"}), HasSubstr("flux_mean_wb"));
  EXPECT_THAT(scenario_refusal({"expect.torque=1"}), HasSubstr("--set: expect.torque: unknown key"));
  EXPECT_THAT(scenario_refusal({"profile.torque_nm={ shape = \"steps\", points = [[1, 2]] }"}),
              HasSubstr("profile.torque_nm: "));
}

TEST(ShippedConfigs, APrintedConfigurationSaysWhatEachKeyMeans) {
  const std::string text = print_config(load_ecu_config(shipped_ecu));
  EXPECT_THAT(text,
              HasSubstr("flux_reference_wb = 1.1  # stator flux linkage that the controller holds where the "
                        "voltage suffices; more "
                        "takes less slip and more current without torque [Wb]; a number from 0.01 to 10; "
                        "default derived from machine and link\n"));
  EXPECT_THAT(text, HasSubstr("\n[control.machine_estimate]\n# r_s_ohm =  # stator resistance; not set: "
                              "that of [machine] [ohm]; a number"));
}

}  // namespace
}  // namespace sextant
