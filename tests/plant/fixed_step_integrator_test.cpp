#include "sextant/plant/fixed_step_integrator.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"

namespace sextant {
namespace {

/// The flux at the end of one run with the given longest step.
SpaceVector<double> flux_after_run(std::int32_t max_step_ns) {
  using Plant = DrivePlant<double>;
  Plant plant{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> integrator{FixedStepParameters{max_step_ns}};
  EXPECT_TRUE(run(plant, integrator, switching_sequence(1000, 5), supply()));
  return plant.psi_s();
}

TEST(FixedStepIntegrator, ConvergesWithTheFourthOrder) {
  // At 25 µs the error is too near to rounding to show the order.
  using Plant = DrivePlant<double>;
  const auto end = [](std::int32_t step_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_speed(120.0);
    PlantInputs<double> inputs = supply();
    inputs.state = switch_states[1];
    plant.set_inputs(inputs);
    FixedStepIntegrator<Plant> integrator{FixedStepParameters{step_ns}};
    EXPECT_TRUE(integrator.advance(plant, 16'000'000));
    return plant.psi_s();
  };
  const SpaceVector<double> exact = end(10'000);
  const double coarse = magnitude(end(200'000) - exact);
  const double fine = magnitude(end(100'000) - exact);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.3);
}

TEST(FixedStepIntegrator, OneStepAPeriodIsEnough) {
  EXPECT_LT(magnitude(flux_after_run(25'000) - flux_after_run(2'500)), 1e-8);
}

TEST(FixedStepIntegrator, EventsDoNotDependOnTheStep) {
  using Plant = DrivePlant<double>;
  const auto end = [](std::int32_t step_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_fluxes({1.1, 0.0}, {1.05, 0.0});
    plant.set_speed(230.0);
    FixedStepIntegrator<Plant> integrator{FixedStepParameters{step_ns}};
    EXPECT_TRUE(run(plant, integrator, std::vector<SwitchState>(800, gates_off), supply()));
    return plant.psi_s();
  };
  EXPECT_LT(magnitude(end(25'000) - end(1'000)), 1e-6);
}

TEST(FixedStepIntegrator, ParametersAreChecked) {
  EXPECT_EQ(FixedStepParameters{}.validate(), nullptr);
  EXPECT_NE(FixedStepParameters{0}.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
