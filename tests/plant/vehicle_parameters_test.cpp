#include "sextant/plant/vehicle_parameters.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

constexpr VehicleParameters vehicle{.mass = 200,
                                    .motors = 2,
                                    .wheel_radius = 0.28,
                                    .rolling_coefficient = 0.01,
                                    .drag_area = 0.8,
                                    .air_density = 1.2,
                                    .grade = 0.05,
                                    .wheel_inertia = 0.4,
                                    .standstill_speed = 0.05};

TEST(VehicleParameters, AMotorFeelsItsShareOfTheForces) {
  const RoadLoad<> road = road_load(vehicle);
  const double v = 12;
  const double alpha = std::atan(0.05);
  const double weight = 200 * 9.80665;
  const double force = weight * (0.01 * std::cos(alpha) + std::sin(alpha)) + 0.5 * 1.2 * 0.8 * v * v;
  EXPECT_NEAR(road.torque(v / 0.28), force * 0.28 / 2, 1e-3);
  const double backwards = weight * (-0.01 * std::cos(alpha) + std::sin(alpha)) - 0.5 * 1.2 * 0.8 * v * v;
  EXPECT_NEAR(road.torque(-v / 0.28), backwards * 0.28 / 2, 1e-3);
}

TEST(VehicleParameters, TorqueOfAllMotorsAcceleratesTheAcceleratedMass) {
  const double rotor = 0.089;
  const RoadLoad<> road = road_load(vehicle);
  const double shaft_acceleration = 10.0 / (rotor + road.coupled_inertia);
  EXPECT_NEAR(shaft_acceleration * 0.28, 2 * 10.0 / 0.28 / accelerated_mass(vehicle, rotor), 1e-12);
  EXPECT_NEAR(accelerated_mass(vehicle, rotor), 200 + 2 * 0.489 / 0.28 / 0.28, 1e-12);
}

// Torques by the ratio, speeds by it, inertias by its square.
TEST(VehicleParameters, AGearDividesForcesAndInertias) {
  VehicleParameters geared = vehicle;
  geared.gear_ratio = 4;
  const RoadLoad<> wheel = road_load(vehicle);
  const RoadLoad<> motor = road_load(geared);
  for (const double omega : {-40.0, 0.02, 3.0, 40.0})
    EXPECT_NEAR(motor.torque(4 * omega), wheel.torque(omega) / 4, 1e-12);
  EXPECT_NEAR(motor.coupled_inertia, wheel.coupled_inertia / 16, 1e-12);
  EXPECT_NEAR(grade_torque(geared, 0.1), grade_torque(vehicle, 0.1) / 4, 1e-12);
  // n i τ/r = m_acc i r/i domega_m/dt
  const double rotor = 0.089;
  const double acceleration = 10.0 / (rotor + motor.coupled_inertia) * 0.28 / 4;
  EXPECT_NEAR(acceleration, 2 * 4 * 10.0 / 0.28 / accelerated_mass(geared, rotor), 1e-12);
}

TEST(VehicleParameters, AreChecked) {
  EXPECT_EQ(VehicleParameters{}.validate(), nullptr);
  EXPECT_FALSE(VehicleParameters{}.is_given());
  EXPECT_EQ(vehicle.validate(), nullptr);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto member :
       {&VehicleParameters::mass, &VehicleParameters::wheel_radius, &VehicleParameters::rolling_coefficient,
        &VehicleParameters::drag_area, &VehicleParameters::air_density, &VehicleParameters::wheel_inertia,
        &VehicleParameters::standstill_speed, &VehicleParameters::gear_ratio,
        &VehicleParameters::brake_torque}) {
    for (const double bad : {-1.0, nan}) {
      VehicleParameters v = vehicle;
      v.*member = bad;
      EXPECT_NE(v.validate(), nullptr);
    }
  }
  VehicleParameters v = vehicle;
  v.motors = 0;
  EXPECT_NE(v.validate(), nullptr);
  v = vehicle;
  v.grade = nan;
  EXPECT_NE(v.validate(), nullptr);
}

/// A machine without flux on a rolling vehicle.
Plant rolling_plant(const VehicleParameters& v, double speed) {
  DrivePlantParameters<> parameters{};
  parameters.road_load = road_load(v);
  Plant plant{parameters};
  plant.set_speed(speed / v.wheel_radius);
  return plant;
}

template <class Integrator>
double speed_after(Plant plant, Integrator integrator, double wheel_radius, int seconds) {
  for (int n = 0; n < 40'000 * seconds; ++n) EXPECT_TRUE(integrator.advance(plant, 25'000));
  return plant.omega_m() * wheel_radius;
}

TEST(VehicleParameters, DragAloneSlowsAVehicleHyperbolically) {
  constexpr VehicleParameters v{.mass = 200, .wheel_radius = 0.28, .drag_area = 0.8};
  // dv/dt = −k v², v = v_0/(1 + k v_0 t)
  const double k =
      0.5 * v.air_density * v.drag_area / accelerated_mass(v, InductionMachineParameters<>{}.inertia);
  const double expected = 20 / (1 + k * 20 * 3);
  EXPECT_NEAR(speed_after(rolling_plant(v, 20), FixedStepIntegrator<Plant>{}, 0.28, 3), expected, 1e-9);
  EXPECT_NEAR(speed_after(rolling_plant(v, -20), FixedStepIntegrator<Plant>{}, 0.28, 3), -expected, 1e-9);
}

TEST(VehicleParameters, AVehicleRollsToRestAndStaysThere) {
  constexpr VehicleParameters v{.mass = 200, .wheel_radius = 0.28, .rolling_coefficient = 0.02};
  EXPECT_LT(std::abs(speed_after(rolling_plant(v, 0.3), FixedStepIntegrator<Plant>{}, 0.28, 8)), 1e-4);
}

TEST(VehicleParameters, UphillItRollsBackByItsWeight) {
  constexpr VehicleParameters v{.mass = 200, .wheel_radius = 0.28, .grade = 0.1};
  const double acceleration =
      200 * 9.80665 * std::sin(std::atan(0.1)) / accelerated_mass(v, InductionMachineParameters<>{}.inertia);
  EXPECT_NEAR(speed_after(rolling_plant(v, 1), FixedStepIntegrator<Plant>{}, 0.28, 2), 1 - 2 * acceleration,
              1e-9);
}

TEST(VehicleParameters, BothIntegratorsAgreeOnTheRoad) {
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    CvodeParameters parameters{};
    parameters.method = method;
    parameters.relative_tolerance = 1e-9;
    Plant plant = rolling_plant(vehicle, 3);
    CvodeIntegrator<Plant> cvode{parameters};
    for (int n = 0; n < 1000; ++n) ASSERT_TRUE(cvode.advance(plant, 1'000'000));
    const double fixed = speed_after(rolling_plant(vehicle, 3), FixedStepIntegrator<Plant>{}, 0.28, 1);
    EXPECT_NEAR(plant.omega_m() * 0.28, fixed, 1e-5);
  }
}

}  // namespace
}  // namespace sextant
