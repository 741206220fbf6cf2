#include "sextant/plant/fixed_step_integrator.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"

namespace sextant {
namespace {

template <class T>
PlantInputs<T> supply() {
  PlantInputs<T> inputs{};
  inputs.u_dc = T(530);
  inputs.tau_l = T(5);
  return inputs;
}

/// The flux at the end of one run with the given longest step.
SpaceVector<double> flux_after_run(std::int32_t max_step_ns) {
  using Plant = DrivePlant<double>;
  Plant plant{DrivePlantParameters<double>{}};
  FixedStepIntegrator<Plant> integrator{FixedStepParameters{max_step_ns}};
  EXPECT_TRUE(run(plant, integrator, switching_sequence(1000, 5), supply<double>()));
  return plant.psi_s();
}

TEST(FixedStepIntegrator, ConvergesWithTheFourthOrder) {
  // At 25 µs the error is too near to rounding to show the order.
  using Plant = DrivePlant<double>;
  const auto end = [](std::int32_t step_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_speed(120.0);
    PlantInputs<double> inputs = supply<double>();
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
    EXPECT_TRUE(run(plant, integrator, std::vector<SwitchState>(800, gates_off), supply<double>()));
    return plant.psi_s();
  };
  EXPECT_LT(magnitude(end(25'000) - end(1'000)), 1e-6);
}

TEST(FixedStepIntegrator, FloatPlantFollowsTheDoubleOne) {
  DrivePlant<double> plant_d{DrivePlantParameters<double>{}};
  DrivePlant<float> plant_f{DrivePlantParameters<float>{}};
  FixedStepIntegrator<DrivePlant<double>> integrator_d;
  FixedStepIntegrator<DrivePlant<float>> integrator_f;
  const auto sequence = switching_sequence(4000, 9);
  ASSERT_TRUE(run(plant_d, integrator_d, sequence, supply<double>()));
  ASSERT_TRUE(run(plant_f, integrator_f, sequence, supply<float>()));
  EXPECT_NEAR(double(plant_f.psi_s().alpha), plant_d.psi_s().alpha, 1e-3);
  EXPECT_NEAR(double(plant_f.psi_s().beta), plant_d.psi_s().beta, 1e-3);
  EXPECT_NEAR(double(plant_f.omega_m()), plant_d.omega_m(), 1e-2);
  // Gates off: the float currents die, too.
  ASSERT_TRUE(run(plant_f, integrator_f, std::vector<SwitchState>(800, gates_off), supply<float>()));
  EXPECT_LT(magnitude(plant_f.i_s()), 1e-3F);
}

TEST(FixedStepIntegrator, FailureKeepsTheOldState) {
  using Plant = DrivePlant<double>;
  FixedStepIntegrator<Plant> integrator;
  for (const SwitchState state :
       {switch_states[1], SwitchState{LegState::high, LegState::low, LegState::off}}) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_fluxes({0.5, 0.1}, {0.5, 0.1});
    PlantInputs<double> inputs = supply<double>();
    inputs.state = state;
    plant.set_inputs(inputs);
    inputs.tau_l = std::numeric_limits<double>::quiet_NaN();
    plant.set_inputs(inputs);
    const Plant::State before = plant.state();
    EXPECT_FALSE(integrator.advance(plant, 50'000));
    EXPECT_EQ(plant.state(), before);
    plant.set_inputs(supply<double>());
    EXPECT_TRUE(integrator.advance(plant, 50'000));
  }
}

TEST(FixedStepIntegrator, NoTimeIsNoChange) {
  using Plant = DrivePlant<double>;
  Plant plant{DrivePlantParameters<double>{}};
  plant.set_speed(3.0);
  const Plant::State before = plant.state();
  FixedStepIntegrator<Plant> integrator;
  EXPECT_TRUE(integrator.advance(plant, 0));
  EXPECT_EQ(plant.state(), before);
}

TEST(FixedStepIntegrator, ParametersAreChecked) {
  EXPECT_EQ(FixedStepParameters{}.validate(), nullptr);
  EXPECT_NE(FixedStepParameters{0}.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
