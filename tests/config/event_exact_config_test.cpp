#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using testing::HasSubstr;

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_scenario_config(shipped_scenario, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(EventExactConfig, GoesToTheRunner) {
  const ScenarioConfig c = load_scenario_config(
      shipped_scenario, {"mode=event_exact", "event_exact.minimum_dwell_ns=50", "event_exact.max_step_us=5",
                         "event_exact.initial_flux_wb=1.1", "plant.integrator=fixed",
                         "protection.over_current_a=321", "control.machine_estimate.r_s_ohm=0.5"});
  ASSERT_EQ(c.mode, ScenarioMode::event_exact);
  const EventExactRunner::Parameters p = c.event_exact_runner();
  EXPECT_EQ(p.event_exact.minimum_dwell_ns, 50);
  EXPECT_EQ(p.event_exact.max_step_ns, 5000);
  EXPECT_EQ(p.event_exact.initial_flux, 1.1);
  EXPECT_EQ(p.integrator, IntegratorKind::fixed);
  EXPECT_EQ(p.protection.over_current, 321);
  EXPECT_EQ(p.control.machine.r_s, 0.5);
  EXPECT_EQ(p.plant.machine.r_s, 0.435);
  EXPECT_EQ(p.u_dc, 530);
}

TEST(EventExactConfig, HasNoControlPeriodToDelayBy) {
  EXPECT_THAT(refusal({"mode=event_exact", "drive.actuation_delay_periods=1"}),
              HasSubstr("actuation_delay_periods must be 0"));
}

TEST(EventExactConfig, HasNoAdditionsToThePapersTable) {
  for (const char* key : {"control.dtc.flux_priority=true", "control.dtc.torque_trim_ms=10"}) {
    SCOPED_TRACE(key);
    EXPECT_THAT(refusal({"mode=event_exact", key}),
                HasSubstr("control.dtc.flux_priority must be false and control.dtc.torque_trim_ms 0"));
    EXPECT_EQ(refusal({key}), "accepted");
  }
}

TEST(EventExactConfig, HasNoStateInWhichToMagnetise) {
  EXPECT_THAT(refusal({"mode=event_exact", "drive.magnetise_first=true"}),
              HasSubstr("event_exact.initial_flux_wb"));
}

TEST(EventExactConfig, HasNoDriveThatChoosesTheFlux) {
  EXPECT_THAT(refusal({"mode=event_exact", "drive.flux_optimum=min_loss"}),
              HasSubstr("drive.flux_optimum must be \"constant\""));
  EXPECT_EQ(refusal({"drive.flux_optimum=min_loss"}), "accepted");
}

TEST(EventExactConfig, HasTwoEnginesOnly) {
  for (const char* integrator : {"exact", "erk"}) {
    SCOPED_TRACE(integrator);
    const std::string key = std::string{"plant.integrator="} + integrator;
    EXPECT_THAT(
        refusal({"mode=event_exact", key}),
        HasSubstr("an event-exact run is moved by cvode or fixed, plant.integrator must be one of them"));
    EXPECT_EQ(refusal({key}), "accepted");
  }
}

TEST(EventExactConfig, NeedsAControllerOfComparators) {
  ScenarioConfig c = load_scenario_config(shipped_scenario, {"mode=event_exact"});
  Schema schema;
  describe(Section{schema}, c);
  const auto problems_at_mode = [&schema] {
    std::string text;
    for (const Check& check : schema.checks) {
      if (check.path == "mode") text += check.problem();
    }
    return text;
  };
  EXPECT_EQ(problems_at_mode(), "");
  c.drive.controller = "another";
  EXPECT_THAT(problems_at_mode(), HasSubstr("control.controller must be \"dtc\""));
  c.mode = ScenarioMode::sampled;
  EXPECT_EQ(problems_at_mode(), "");
}

TEST(EventExactConfig, IsRefusedAtTheLineOfItsMode) {
  EXPECT_THAT(refusal({"mode=event_exact", "drive.actuation_delay_periods=1"}),
              HasSubstr("--set: mode: an event-exact run has no control period"));
}

TEST(EventExactConfig, TakesAnyTraceInterval) {
  EXPECT_EQ(refusal({"mode=event_exact", "trace.interval_us=3"}), "accepted");
  EXPECT_THAT(refusal({"trace.interval_us=3"}), HasSubstr("whole number of control periods"));
}

TEST(EventExactConfig, NamesAnUnknownMode) {
  EXPECT_THAT(refusal({"mode=exact"}), HasSubstr("event_exact"));
}

}  // namespace
}  // namespace sextant
