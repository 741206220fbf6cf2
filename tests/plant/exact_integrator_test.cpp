#include "sextant/plant/exact_integrator.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

double torque_error(const std::vector<double>& a, const std::vector<double>& b) {
  double error = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) error = std::max(error, std::abs(a[n] - b[n]));
  return error;
}

/// Torque at the end of each period of a switching sequence.
std::vector<double> torques(Plant plant, PlantIntegrator<Plant>& integrator, PlantInputs<double> inputs) {
  std::vector<double> tau_e;
  for (const SwitchState state : switching_sequence(4000, 17)) {
    inputs.state = state;
    plant.set_inputs(inputs);
    EXPECT_TRUE(integrator.advance(plant, switching_period_ns));
    tau_e.push_back(plant.tau_e());
  }
  return tau_e;
}

TEST(ExactIntegrator, HasNoErrorAtConstantSpeedWhateverTheStep) {
  const auto end = [](PlantIntegrator<Plant>& integrator) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_speed(120.0);
    PlantInputs<double> inputs = supply();
    inputs.imposed_speed = true;
    for (const std::size_t vector : {1U, 2U, 0U, 3U}) {
      inputs.state = switch_states[vector];
      plant.set_inputs(inputs);
      EXPECT_TRUE(integrator.advance(plant, 10'000'000));
    }
    return plant;
  };
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
  const Plant reference = end(fine);
  for (const std::int32_t step_ns : {1'000, 25'000, 10'000'000}) {
    SCOPED_TRACE(step_ns);
    ExactIntegrator<Plant> exact{ExactParameters{step_ns}};
    const Plant plant = end(exact);
    EXPECT_LT(magnitude(plant.psi_s() - reference.psi_s()), 1e-11 * magnitude(reference.psi_s()));
    EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), 1e-11 * magnitude(reference.psi_r()));
    EXPECT_EQ(plant.omega_m(), 120.0);
    EXPECT_NEAR(plant.theta_m(), 120.0 * 0.04, 1e-11);
  }
}

/// The order that a step and a quarter of it show, against a fine Runge-Kutta run.
double order(const Plant& start, const PlantInputs<double>& inputs, std::int32_t step_ns = 25'000) {
  FixedStepIntegrator<Plant> fine{FixedStepParameters{500}};
  ExactIntegrator<Plant> coarse{ExactParameters{step_ns}};
  ExactIntegrator<Plant> halved{ExactParameters{step_ns / 4}};
  const std::vector<double> reference = torques(start, fine, inputs);
  const double ratio = torque_error(torques(start, coarse, inputs), reference) /
                       torque_error(torques(start, halved, inputs), reference);
  return std::log2(ratio) / 2.0;
}

TEST(ExactIntegrator, IsOfOrderThreeWhereTheSpeedChanges) {
  const Plant free_shaft{DrivePlantParameters<double>{}};
  EXPECT_NEAR(order(free_shaft, supply()), 3.0, 0.3);

  PlantInputs<double> ramp = supply();
  ramp.imposed_speed = true;
  ramp.speed_slope = 4000.0;
  EXPECT_NEAR(order(free_shaft, ramp), 3.0, 0.3);

  // Friction and road load, too, are part of it.
  DrivePlantParameters<double> loaded{};
  loaded.machine.inertia = 0.002;
  loaded.viscous_friction = 0.05;
  loaded.road_load = {.quadratic_drag = 1e-4, .rolling_torque = 2.0};
  Plant vehicle{loaded};
  vehicle.set_speed(20.0);
  // So light a shaft gets steps that are shorter than a period.
  EXPECT_NEAR(order(vehicle, supply(), 8'000), 3.0, 0.5);
}

TEST(ExactIntegrator, AngleIsOfOrderTwo) {
  const auto end = [](PlantIntegrator<Plant>& integrator) {
    Plant plant{DrivePlantParameters<double>{}};
    PlantInputs<double> inputs = supply();
    inputs.imposed_speed = false;
    EXPECT_TRUE(run(plant, integrator, switching_sequence(2000, 5), inputs));
    return plant.theta_m();
  };
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
  ExactIntegrator<Plant> coarse{ExactParameters{25'000}};
  ExactIntegrator<Plant> halved{ExactParameters{6'250}};
  const double reference = end(fine);
  EXPECT_NEAR(std::log2((end(coarse) - reference) / (end(halved) - reference)) / 2.0, 2.0, 0.3);
}

TEST(ExactIntegrator, WhileLegsAreOffItIsTheFixedStep) {
  const std::vector<SwitchState> open{600, gates_off};
  Plant by_exact{DrivePlantParameters<double>{}};
  by_exact.set_fluxes({1.1, 0.0}, {1.05, 0.0});
  by_exact.set_speed(230.0);
  Plant by_fixed = by_exact;
  ExactIntegrator<Plant> exact{{}, FixedStepParameters{5'000}};
  FixedStepIntegrator<Plant> fixed{FixedStepParameters{5'000}};
  ASSERT_TRUE(run(by_exact, exact, open, supply()));
  ASSERT_TRUE(run(by_fixed, fixed, open, supply()));
  EXPECT_EQ(by_exact.state(), by_fixed.state());
}

TEST(ExactIntegrator, TakesUpEachChangeOfSpeedStepAndPlant) {
  // One integrator with all that it remembers against new ones.
  ExactIntegrator<Plant> old{ExactParameters{100'000}};
  Plant plant{DrivePlantParameters<double>{}};
  PlantInputs<double> inputs = supply();
  inputs.state = switch_states[1];
  inputs.imposed_speed = true;
  const auto expect_same = [&](std::int64_t duration_ns) {
    Plant twin = plant;
    ExactIntegrator<Plant> fresh{ExactParameters{100'000}};
    ASSERT_TRUE(old.advance(plant, duration_ns));
    ASSERT_TRUE(fresh.advance(twin, duration_ns));
    EXPECT_EQ(plant.state(), twin.state());
  };
  plant.set_inputs(inputs);
  expect_same(25'000);
  expect_same(10'000);
  plant.set_speed(77.0);
  expect_same(10'000);
  DrivePlantParameters<double> other{};
  other.machine.r_s = 3.0;
  plant = Plant{other};
  plant.set_inputs(inputs);
  plant.set_speed(77.0);
  old.reset();
  expect_same(10'000);
}

TEST(ExactIntegrator, ParametersAreChecked) {
  EXPECT_EQ(ExactParameters{}.validate(), nullptr);
  EXPECT_NE(ExactParameters{0}.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
