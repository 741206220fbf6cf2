// A drive behind a DC link that is charged through a resistor first: what it makes of an enable before that,
// of a contactor that does not close, and of one that is welded.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run/period_by_period.hpp"

namespace sextant {
namespace {

using Stage = LinkedMeteredPowerStage;
using Link = DcLink<>;

constexpr int paper = 1;
constexpr double u_0 = 530;
constexpr DcLinkParameters<> link{.capacitance = 1e-3,
                                  .source_resistance = 0.2,
                                  .initial_voltage = 0.0,
                                  .precharge_resistance = 50,
                                  .contactor_share = 0.9};
/// When the contactor closes. [s]
const double closes_s = -(50 + 0.2) * 1e-3 * std::log(1 - 0.9);

ScenarioConfig config_with(const std::string& torque, double end_s,
                           const std::vector<std::string>& set = {}) {
  ScenarioConfig config = machine_config(
      test_machines[paper],
      {.controller = "foc", .period_us = 50, .omega_m = 100, .end_s = end_s, .torque = torque, .set = set});
  config.drive.plant.link = link;
  config.drive.plant.integrator = IntegratorKind::fixed;
  return config;
}

const Link& link_of(const Stage::Plant& plant) {
  return plant.appended_system().first;
}

// The drive is enabled from the beginning.
TEST(PrechargeRun, TheDriveWaitsForTheLinkAndSaysSo) {
  const ScenarioConfig config = config_with("[[0, 0], [0.5, 40]]", 0.7, {"capability.ready_voltage_v=480"});
  double ready_s = -1, closed_s = -1;
  go_through<Stage>(config, [&](double t, const Telemetry<double>& now, const Stage::Io& io) {
    EXPECT_FALSE(now.latched.any());
    if (closed_s < 0 && link_of(io.plant()).is_closed()) closed_s = t;
    if (ready_s < 0 && now.state == DriveState::ready && t > 0) ready_s = t;
    if (t > 1e-3 && t < closes_s - 1e-3) {
      EXPECT_EQ(now.state, DriveState::standby);
      EXPECT_EQ(now.derating_cause, DeratingCause::dc_link_low);
      EXPECT_NEAR(io.plant().u_dc(), u_0 * -std::expm1(-(t + 0.2e-3) / 50.2e-3), 0.1);
    }
    if (t > 0.65) {
      EXPECT_NEAR(io.plant().tau_e(), 40, 2);
    }
  });
  EXPECT_NEAR(closed_s, closes_s, 0.3e-3);
  EXPECT_GE(ready_s, closed_s);
  EXPECT_LT(ready_s, closed_s + 1e-3);
}

MilResult run_linked(const ScenarioConfig& config) {
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
}

// Without a level of its own the drive is ready from the trip level on, half of the link's voltage: it
// magnetises through the resistor, and trips.
TEST(PrechargeRun, TheTripLevelIsTheLevelByDefault) {
  const MilResult result = run_linked(config_with("[[0, 0]]", 0.2));
  EXPECT_EQ(result.first_fault, Fault::dc_under_voltage);
  EXPECT_GT(result.fault_ns, 1e9 * (50.2e-3 * std::log(2.0) - 0.5e-3));
  EXPECT_LT(result.fault_ns, 1e9 * closes_s);
}

MilResult run_broken(PlantFaultKind kind, const std::string& torque) {
  ScenarioConfig config = config_with(torque, 1.0, {"capability.ready_voltage_v=450"});
  config.drive.plant.io.fault.kind = kind;
  return run_linked(config);
}

// Through 50 Ω the source delivers 1.4 kW at most: the machine magnetises, and 6 kW are too much.
TEST(PrechargeRun, BehindAContactorThatDoesNotCloseATorqueTrips) {
  EXPECT_FALSE(run_broken(PlantFaultKind::contactor_open, "[[0, 0]]").faults.any());
  const MilResult result = run_broken(PlantFaultKind::contactor_open, "[[0, 0], [0.7, 60]]");
  EXPECT_EQ(result.final_state, DriveState::fault);
  EXPECT_EQ(result.first_fault, Fault::dc_under_voltage);
  EXPECT_GT(result.fault_ns, 700'000'000);
}

// The capacitor takes u_0/R at once, and the drive need not wait.
TEST(PrechargeRun, BehindAWeldedContactorTheLinkIsChargedAtOnce) {
  ScenarioConfig config = config_with("[[0, 0]]", 0.5, {"capability.ready_voltage_v=480"});
  config.drive.plant.io.fault.kind = PlantFaultKind::contactor_welded;
  double ready_s = -1, inrush = 0;
  go_through<Stage>(config, [&](double t, const Telemetry<double>& now, const Stage::Io& io) {
    if (ready_s < 0 && now.state == DriveState::ready) ready_s = t;
    const auto y = Stage::Plant::states_of<Link>(io.plant().state());
    inrush = std::max(inrush, link_of(io.plant()).current(y, u_0));
  });
  EXPECT_GT(inrush, 0.5 * u_0 / 0.2);
  EXPECT_LT(ready_s, 1e-3);
}

}  // namespace
}  // namespace sextant
