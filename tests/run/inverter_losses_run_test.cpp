// Runs of a drive whose inverter has losses: the energy closes, drops are not counted twice, and metrics have
// losses and temperatures.
#include <cmath>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"

namespace sextant {
namespace {

constexpr int paper = 1;

ScenarioConfig lossy_config(IntegratorKind integrator, const char* torque = "[[0, 0], [0.2, 60]]") {
  ScenarioConfig config =
      machine_config(test_machines[paper],
                     {.controller = "foc", .period_us = 50, .omega_m = 100, .end_s = 0.4, .torque = torque});
  config.drive.plant.integrator = integrator;
  InverterLossParameters& losses = config.drive.plant.losses;
  losses.switch_voltage = {{{0, 0.8}, {75, 1.9}}, {{0, 0.7}, {75, 2.3}}};
  losses.diode_voltage = {{{0, 0.9}, {75, 1.7}}, {}};
  losses.turn_on = {{{0, 0}, {75, 6e-3}}, {{0, 0}, {75, 9e-3}}};
  losses.turn_off = {{{0, 0}, {75, 5e-3}}, {}};
  losses.recovery = {{{0, 0.5e-3}, {75, 4e-3}}, {}};
  losses.switch_network = {{0.1, 0.01}, {0.2, 0.05}};
  losses.diode_network = {{0.3, 0.01}, {0.3, 0.05}};
  losses.case_network = {{0.05, 0.2}};
  return config;
}

template <class Stage>
MilResult run_on(const ScenarioConfig& config) {
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
}

void expect_losses(const MetricList& m) {
  EXPECT_LT(m[Metric::energy_unaccounted], 1e-5);
  // By the window's mean over its 100 ms; what is drawn lags by one of 2000 periods.
  EXPECT_GT(m[Metric::inverter_loss], 100);
  EXPECT_NEAR(m[Metric::energy_inverter], 0.1 * m[Metric::inverter_loss], 1e-3 * m[Metric::energy_inverter]);
  const double in = m[Metric::energy_from_link] - m[Metric::energy_to_link];
  EXPECT_NEAR(m[Metric::inverter_efficiency], 1 - 0.1 * m[Metric::inverter_loss] / in, 1e-9);
  EXPECT_GT(m[Metric::junction_temperature], m[Metric::case_temperature] + 5);
  EXPECT_GT(m[Metric::case_temperature], 41);
}

TEST(InverterLossesRun, TheEnergyCloses) {
  for (const IntegratorKind integrator : {IntegratorKind::exact, IntegratorKind::cvode}) {
    SCOPED_TRACE(int(integrator));
    const MilResult result = run_on<MeteredPowerStage>(lossy_config(integrator));
    EXPECT_TRUE(result.plant_healthy);
    expect_losses(result.metrics);
  }
}

// The capacitor gives what the inverter loses: with what it does not give the source's balance would be off
// by a few percent.
TEST(InverterLossesRun, TheEnergyClosesBehindALinkWithCapacitance) {
  ScenarioConfig config = lossy_config(IntegratorKind::fixed);
  config.drive.plant.link = {2e-3, 0.2};
  const MilResult result = run_on<LinkedMeteredPowerStage>(config);
  EXPECT_TRUE(result.plant_healthy);
  expect_losses(result.metrics);
  const MetricList& m = result.metrics;
  const double in = m[Metric::energy_from_link] - m[Metric::energy_to_link];
  EXPECT_NEAR(in, m[Metric::energy_source] - m[Metric::energy_source_loss] - m[Metric::energy_stored],
              1e-3 * in);
}

// Curves that are the plant's own drops: nothing is left to draw, with dead time too.
TEST(InverterLossesRun, DropsAreNotCountedTwice) {
  ScenarioConfig config = lossy_config(IntegratorKind::fixed);
  SimulatedPowerStageParameters& plant = config.drive.plant;
  plant.plant.drops = {1.2, 0.02};
  plant.io.dead_time_ns = 1'500;
  plant.losses = {};
  plant.losses.switch_voltage.cold = plant.losses.diode_voltage.cold = {{0, 1.2}, {100, 3.2}};
  const MilResult result = run_on<MeteredPowerStage>(config);
  const MetricList& m = result.metrics;
  EXPECT_LT(m[Metric::energy_unaccounted], 1e-5);
  EXPECT_GT(m[Metric::inverter_loss], 50);
  EXPECT_LT(std::abs(m[Metric::energy_inverter]), 1e-3 * 0.1 * m[Metric::inverter_loss]);
}

TEST(InverterLossesRun, ARegeneratingInverterLosesOfWhatTheMachineGives) {
  const ScenarioConfig config = lossy_config(IntegratorKind::exact, "[[0, 0], [0.2, -60]]");
  const MetricList m = run_on<MeteredPowerStage>(config).metrics;
  const double out = m[Metric::energy_to_link] - m[Metric::energy_from_link];
  ASSERT_GT(out, 0);
  const double lost = 0.1 * m[Metric::inverter_loss];
  EXPECT_NEAR(m[Metric::inverter_efficiency], out / (out + lost), 1e-9);
  EXPECT_GT(m[Metric::inverter_efficiency], 0.9);
}

// At a small regenerated power the losses take what the machine gives, and more of the link: nothing comes
// out.
TEST(InverterLossesRun, AnInverterThatLinkAndMachineFeedHasNoEfficiency) {
  ScenarioConfig config = lossy_config(IntegratorKind::exact, "[[0, 0], [0.2, -10]]");
  config.scenario.load.imposed_speed = ProfileParameters{.value = 22};
  const MetricList m = run_on<MeteredPowerStage>(config).metrics;
  ASSERT_GT(m[Metric::energy_from_link], m[Metric::energy_to_link]);
  ASSERT_LT(m[Metric::energy_shaft], 0);
  EXPECT_EQ(m[Metric::inverter_efficiency], 0);
}

TEST(InverterLossesRun, WithoutCurvesTheyAreUnknownAndTheRunIsTheSame) {
  ScenarioConfig config = lossy_config(IntegratorKind::exact);
  const MetricList with = run_on<MeteredPowerStage>(config).metrics;
  config.drive.plant.losses = {};
  const MetricList without = run_on<MeteredPowerStage>(config).metrics;
  for (const Metric m : {Metric::energy_inverter, Metric::inverter_loss, Metric::inverter_efficiency,
                         Metric::junction_temperature, Metric::case_temperature})
    EXPECT_TRUE(std::isnan(without[m]));
  // On a stiff link losses change nothing but the link's energy, by what they draw.
  const auto net = [](const MetricList& m) {
    return m[Metric::energy_from_link] - m[Metric::energy_to_link];
  };
  EXPECT_NEAR(net(with) - net(without), with[Metric::energy_inverter], 1e-6 * net(with));
  EXPECT_EQ(with[Metric::torque_error_rms], without[Metric::torque_error_rms]);
  EXPECT_EQ(with[Metric::energy_copper], without[Metric::energy_copper]);
}

TEST(InverterLossesRun, APowerStageWithoutAMeterRefusesThem) {
  const ScenarioConfig config = lossy_config(IntegratorKind::fixed);
  EXPECT_THROW((SimulatedPowerStage{config.drive.plant, config.scenario.load}), std::runtime_error);
}

}  // namespace
}  // namespace sextant
