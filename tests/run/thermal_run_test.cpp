// Runs of a drive whose machine heats: what is lost is where it heats, the energy closes, and metrics have
// the temperatures.
#include <cmath>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"

namespace sextant {
namespace {

constexpr int paper = 1;

/// The paper's machine at a constant speed and torque, no heat leaving a node within the run; its
/// temperatures move each control period.
ScenarioConfig heating_config(IntegratorKind integrator) {
  ScenarioConfig config = machine_config(
      test_machines[paper],
      {.controller = "foc", .period_us = 50, .omega_m = 100, .end_s = 0.6, .torque = "[[0, 0], [0.3, 40]]"});
  config.drive.plant.integrator = integrator;
  config.drive.plant.plant.viscous_friction = 0.01;
  ThermalParameters<>& thermal = config.drive.plant.thermal;
  thermal.capacity = {10, 15, 40};
  thermal.to_ambient = {1e-9, 1e-9, 1e-9};
  thermal.start.rotor = 60;
  thermal.step_ns = 50'000;
  config.scenario.metrics.from_ns = 0;
  return config;
}

template <class Stage>
MilResult run_on(const ScenarioConfig& config) {
  Stage stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
}

/// Winding and rotor have the copper loss, the housing iron loss and friction, each but for a period.
void expect_heat(const MetricList& m) {
  const double windings =
      10 * (m[Metric::winding_temperature] - 20) + 15 * (m[Metric::rotor_temperature] - 60);
  EXPECT_GT(m[Metric::winding_temperature], 22);
  EXPECT_GT(m[Metric::rotor_temperature], 61);
  EXPECT_NEAR(windings, m[Metric::energy_copper], 1e-3 * m[Metric::energy_copper]);
  const double rest = m[Metric::energy_iron] + 0.01 * 100 * 100 * 0.6;
  EXPECT_NEAR(40 * (m[Metric::housing_temperature] - 20), rest, 1e-3 * rest);
}

TEST(ThermalRun, HeatIsWhatIsLostAndTheEnergyCloses) {
  for (const IntegratorKind integrator :
       {IntegratorKind::cvode, IntegratorKind::fixed, IntegratorKind::erk, IntegratorKind::exact}) {
    SCOPED_TRACE(int(integrator));
    ScenarioConfig config = heating_config(integrator);
    if (integrator != IntegratorKind::exact) config.drive.plant.plant.iron_loss = {600, 900, 314};
    const MilResult result = run_on<MeteredPowerStage>(config);
    EXPECT_TRUE(result.plant_healthy);
    EXPECT_LT(result.metrics[Metric::energy_unaccounted], 1e-5) << "restarted in every period";
    expect_heat(result.metrics);
  }
}

TEST(ThermalRun, TheSameBehindALinkWithCapacitance) {
  ScenarioConfig config = heating_config(IntegratorKind::fixed);
  config.drive.plant.link = {2e-3, 0.2};
  const MilResult result = run_on<LinkedMeteredPowerStage>(config);
  EXPECT_TRUE(result.plant_healthy);
  EXPECT_LT(result.metrics[Metric::energy_unaccounted], 1e-6);
  expect_heat(result.metrics);
}

TEST(ThermalRun, WithoutANetworkTemperaturesAreUnknown) {
  ScenarioConfig config = heating_config(IntegratorKind::fixed);
  config.drive.plant.thermal = {};
  const MilResult result = run_on<MeteredPowerStage>(config);
  EXPECT_GT(result.metrics[Metric::energy_copper], 1);
  for (const Metric m : {Metric::winding_temperature, Metric::rotor_temperature, Metric::housing_temperature})
    EXPECT_TRUE(std::isnan(result.metrics[m]));
}

}  // namespace
}  // namespace sextant
