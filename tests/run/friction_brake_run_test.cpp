// The friction brake of a vehicle: Coulomb's law at the shaft, and how a driver divides a torque among motor
// and brake.

#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/plant/vehicle_parameters.hpp"
#include "sextant/profiles/driver.hpp"
#include "sextant/run/mil_runner.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr double seconds = 1e-9 * period_ns;
constexpr double rotor = InductionMachineParameters<>{}.inertia;

/// A vehicle whose gates are off.
struct Rolling {
  explicit Rolling(const VehicleParameters& vehicle, double speed)
      : stage{parameters(vehicle, speed), MechanicalLoad::Parameters{}} {
    (void)stage.io().read(0);
  }

  /// Over so many periods; speed of the motor at the end. [rad/s]
  double roll(int periods) {
    for (int n = 0; n < periods; ++n) {
      t_ns += period_ns;
      (void)stage.io().read(t_ns);
    }
    EXPECT_TRUE(stage.io().healthy());
    return stage.io().plant().omega_m();
  }

  static SimulatedPowerStageParameters parameters(const VehicleParameters& vehicle, double speed) {
    SimulatedPowerStageParameters p;
    p.integrator = IntegratorKind::fixed;
    p.plant.road_load = road_load(vehicle);
    p.plant.initial.speed = speed;
    p.io.period_ns = period_ns;
    return p;
  }

  SimulatedPowerStage stage;
  std::int64_t t_ns{0};
};

constexpr VehicleParameters level{.mass = 200, .wheel_radius = 0.28, .gear_ratio = 4};

double inertia(const VehicleParameters& vehicle) {
  return rotor + road_load(vehicle).coupled_inertia;
}

// omega = omega_0 − τ/J t down to zero, where it stays; the brake gets the kinetic energy.
TEST(FrictionBrakeRun, AConstantTorqueSlowsAVehicleLinearlyToRest) {
  for (const double start : {50.0, -50.0}) {
    Rolling rolling{level, start};
    rolling.stage.io().set_brake(10.0);
    const double slope = -std::copysign(10.0, start) / inertia(level);
    const int stops = int(-start / slope / seconds);
    EXPECT_NEAR(rolling.roll(stops / 2), start + slope * seconds * (stops / 2), 1e-9);
    EXPECT_NEAR(rolling.stage.io().tau_l(), std::copysign(10.0, start), 1e-12);
    EXPECT_EQ(rolling.roll(stops / 2 + 3), 0.0);
    const double theta = rolling.stage.io().plant().theta_m();
    EXPECT_EQ(rolling.roll(2000), 0.0);
    EXPECT_EQ(rolling.stage.io().plant().theta_m(), theta);
    ASSERT_TRUE(rolling.stage.io().brake_energy());
    const double kinetic = 0.5 * inertia(level) * start * start;
    EXPECT_NEAR(*rolling.stage.io().brake_energy(), kinetic, 1e-6 * kinetic);
  }
}

TEST(FrictionBrakeRun, AVehicleOnAGradeIsHeldByNoLessThanItsWeight) {
  VehicleParameters hill = level;
  hill.grade = 0.12;
  const double weight = grade_torque(hill, hill.grade);
  Rolling held{hill, 0.0};
  held.stage.io().set_brake(1.001 * weight);
  EXPECT_EQ(held.roll(4000), 0.0);
  EXPECT_EQ(*held.stage.io().brake_energy(), 0.0);

  Rolling slides{hill, 0.0};
  slides.stage.io().set_brake(0.8 * weight);
  EXPECT_NEAR(slides.roll(4000), -0.2 * weight / inertia(hill) * 4000 * seconds, 1e-9);
  const double way = -slides.stage.io().plant().theta_m();
  EXPECT_NEAR(*slides.stage.io().brake_energy(), 0.8 * weight * way, 1e-3 * weight * way)
      << "but for the last piece";

  held.stage.io().set_brake(0.0);
  EXPECT_NEAR(held.roll(4000), -weight / inertia(hill) * 4000 * seconds, 1e-9);
}

// Uphill at first: it comes to rest by weight and brake, and rolls back against the brake.
TEST(FrictionBrakeRun, ABrakeThatDoesNotHoldOpposesTheMotionBothWays) {
  VehicleParameters hill = level;
  hill.grade = 0.12;
  const double weight = grade_torque(hill, hill.grade);
  Rolling rolling{hill, 20.0};
  rolling.stage.io().set_brake(0.5 * weight);
  const double up_s = 20.0 * inertia(hill) / (1.5 * weight);
  const int up = int(up_s / seconds);
  (void)rolling.roll(up);
  const double expected = -0.5 * weight / inertia(hill) * ((up + 4000) * seconds - up_s);
  // A period of the wrong sign at most.
  EXPECT_NEAR(rolling.roll(4000), expected, weight / inertia(hill) * seconds);
}

TEST(FrictionBrakeRun, WithoutABrakeThereIsNoEnergyOfIt) {
  Rolling rolling{level, 10.0};
  rolling.stage.io().set_brake(0.0);
  (void)rolling.roll(10);
  EXPECT_FALSE(rolling.stage.io().brake_energy());
}

Driver::Parameters braking_driver() {
  return {.period_ns = 10'000'000,
          .mass = 200,
          .wheel_radius = 0.28,
          .motors = 2,
          .torque_limit = 40,
          .brake_torque = 100,
          .regeneration_from = 2};
}

TEST(FrictionBrakeRun, TheBrakeDoesWhatTheMotorDoesNot) {
  const auto decided = [](double v_ref, double v, double available) {
    Driver driver{braking_driver()};
    driver.note_regenerating(available);
    (void)driver.step(0, v_ref, v);
    return std::pair{driver.torque(), driver.brake_torque()};
  };
  const double gain = 200 * 0.28 / 2 * 4;  // of the proportional part [N·m·s/m]
  const auto [drives, released] = decided(10, 9.9, 1e3);
  EXPECT_NEAR(drives, gain * 0.1, 1e-9);
  EXPECT_EQ(released, 0.0);
  const auto [light, none] = decided(9.9, 10, 1e3);
  EXPECT_NEAR(light, -gain * 0.1, 1e-9);
  EXPECT_NEAR(none, 0, 1e-9);
  const auto [most, rest] = decided(9, 10, 1e3);
  EXPECT_EQ(most, -40);
  EXPECT_NEAR(rest, gain - 40, 1e-9);
  const auto [derated, more] = decided(9, 10, 15);
  EXPECT_EQ(derated, -15);
  EXPECT_NEAR(more, gain - 15, 1e-9);
  const auto [faded, blended] = decided(0.1, 1, 1e3);
  EXPECT_NEAR(faded, -20, 1e-9) << "half of it, at half of the speed of full regeneration";
  EXPECT_NEAR(blended, 0.9 * gain - 20, 1e-9);
  EXPECT_EQ(decided(0, 0.01, 1e3), (std::pair{0.0, 100.0})) << "holds";
  EXPECT_EQ(decided(0, 10, 1e3), (std::pair{-40.0, 100.0})) << "all there is";
}

RigParameters vehicle_rig() {
  RigParameters p;
  VehicleParameters hill = level;
  hill.gear_ratio = 1;
  hill.grade = 0.02;
  hill.rolling_coefficient = 0.01;
  p.stage.plant.road_load = road_load(hill);
  p.drive.protection.over_current = 250;
  return p;
}

// Away and back to rest on a grade: with the brake the motor returns less, and the vehicle stands.
TEST(FrictionBrakeRun, ACycleEndsAtRestOnAGrade) {
  const auto run = [](double brake_torque, double& end_speed) {
    const RigParameters p = vehicle_rig();
    MeteredPowerStage stage{p.stage, p.load};
    DirectTorqueController<double> controller{p.controller};
    Drive<double> drive{p.drive, controller};
    Scenario scenario;
    scenario.duration_ns = 3'000'000'000;
    Driver::Parameters driver = braking_driver();
    driver.mass = accelerated_mass({.mass = 200, .wheel_radius = 0.28}, rotor);
    driver.torque_limit = 100;
    driver.brake_torque = brake_torque;
    scenario.cycle = DrivenCycle{
        {.shape = ProfileShape::linear, .points = {{0, 0}, {0.3, 0}, {1.3, 3}, {1.6, 3}, {2.6, 0}, {3, 0}}},
        driver};
    const MilResult result = MilRunner{drive, stage.io(), period_ns}.run(scenario, nullptr, {});
    EXPECT_FALSE(result.faults.any());
    EXPECT_FALSE(result.cycle_departure);
    end_speed = stage.io().plant().omega_m();
    return result.metrics;
  };
  double with_speed = -1, without_speed = -1;
  const MetricList with = run(100, with_speed);
  const MetricList without = run(0, without_speed);
  EXPECT_EQ(with_speed, 0.0);
  EXPECT_NE(without_speed, 0.0);
  EXPECT_TRUE(std::isnan(without[Metric::energy_brake]));
  // What the brake takes is missing from what the shaft gives back, both runs along the same speeds.
  EXPECT_GT(with[Metric::energy_brake], 20);
  const double missing = with[Metric::energy_shaft] - without[Metric::energy_shaft];
  EXPECT_NEAR(with[Metric::energy_brake], missing, 0.05 * missing);
}

}  // namespace
}  // namespace sextant
