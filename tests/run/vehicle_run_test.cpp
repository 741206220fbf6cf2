// The drive moves a vehicle along a speed: driver, drive, machine and road in one run.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/plant/vehicle_parameters.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr VehicleParameters vehicle{
    .mass = 200, .wheel_radius = 0.28, .rolling_coefficient = 0.01, .drag_area = 2.4};

RigParameters vehicle_rig() {
  RigParameters p;
  p.stage.plant.road_load = road_load(vehicle);
  p.drive.protection.over_current = 250;
  return p;
}

/// Away, along and back to rest within 5 s.
Scenario drive_away_and_brake() {
  Scenario scenario;
  scenario.name = "vehicle";
  scenario.duration_ns = 5'000'000'000;
  scenario.cycle = DrivenCycle{
      {.shape = ProfileShape::linear, .points = {{0, 0}, {0.5, 0}, {2, 3}, {3, 3}, {4.5, 0}, {5, 0}}},
      {.mass = accelerated_mass(vehicle, 0.089), .wheel_radius = vehicle.wheel_radius, .motors = 2}};
  return scenario;
}

struct Telling {
  Telemetry<double> last{};
  void push(const Telemetry<double>& t) noexcept { last = t; }
};

TEST(VehicleRun, TheSpeedFollowsAndTheMotorBrakes) {
  const RigParameters p = vehicle_rig();
  SimulatedPowerStage stage{p.stage, p.load};
  DirectTorqueController<double> controller{p.controller};
  Drive<double> drive{p.drive, controller};
  const Scenario scenario = drive_away_and_brake();
  ScenarioCommands commands{scenario};
  const Profile speed{scenario.cycle->speed};
  Telling telemetry;
  double square = 0, worst = 0, energy_back = 0, energy_out = 0;
  std::int64_t samples = 0;
  for (std::int64_t t = -4 * period_ns; t <= scenario.duration_ns; t += period_ns) {
    run_cycle(t, stage.io(), commands, drive, telemetry);
    commands.note_speed(telemetry.last.omega_m);
    if (t < 0) continue;
    const auto& plant = stage.io().plant();
    const double error = speed.value(t) - vehicle.wheel_radius * plant.omega_m();
    square += error * error;
    worst = std::max(worst, std::abs(error));
    ++samples;
    const double work = plant.tau_e() * plant.omega_m() * period_ns * 1e-9;
    (work > 0 ? energy_out : energy_back) += std::abs(work);
    if (t == 1'250'000'000) {
      EXPECT_NEAR(stage.io().tau_l(), plant.tau_road(), 1e-12);
      EXPECT_GT(stage.io().tau_l(), 1.0) << "the trace's load torque is the road's";
    }
  }
  EXPECT_FALSE(telemetry.last.latched.any());
  EXPECT_LT(std::sqrt(square / double(samples)), 0.1);
  EXPECT_LT(worst, 0.4);
  // 1/2 m v² of one motor's share is 460 J; the air and the wheels keep some of it.
  EXPECT_GT(energy_out, 450);
  EXPECT_GT(energy_back, 250);
}

TEST(VehicleRun, TheRunnerTakesTheDriver) {
  const RigParameters p = vehicle_rig();
  MeteredPowerStage stage{p.stage, p.load};
  DirectTorqueController<double> controller{p.controller};
  Drive<double> drive{p.drive, controller};
  Scenario scenario = drive_away_and_brake();
  scenario.duration_ns = 2'500'000'000;
  const MilResult result = MilRunner{drive, stage.io(), period_ns}.run(scenario, nullptr, {});
  EXPECT_FALSE(result.faults.any());
  EXPECT_TRUE(result.plant_healthy);
  EXPECT_NEAR(stage.io().plant().omega_m() * vehicle.wheel_radius, 3.0, 0.2);
  EXPECT_LT(result.metrics[Metric::speed_error_rms] * vehicle.wheel_radius, 0.1);
  EXPECT_GT(result.metrics[Metric::speed_error_rms], 0.0);
  EXPECT_FALSE(result.cycle_departure);
}

TEST(VehicleRun, ADriverWithoutTheTorqueForItsCycleDoesNotFollow) {
  const RigParameters p = vehicle_rig();
  MeteredPowerStage stage{p.stage, p.load};
  DirectTorqueController<double> controller{p.controller};
  Drive<double> drive{p.drive, controller};
  Scenario scenario = drive_away_and_brake();
  scenario.duration_ns = 4'000'000'000;
  scenario.cycle->driver.torque_limit = 8;  // 2 m/s² take 28 N·m
  const MilResult result = MilRunner{drive, stage.io(), period_ns}.run(scenario, nullptr, {});
  EXPECT_FALSE(result.missing_torque);
  ASSERT_TRUE(result.cycle_departure);
  EXPECT_GT(result.cycle_departure->farthest, CycleFollowing::tolerance);
  EXPECT_GT(result.cycle_departure->duration_ns, 1'000'000'000);
}

}  // namespace
}  // namespace sextant
