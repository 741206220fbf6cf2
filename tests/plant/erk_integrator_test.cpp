#include "sextant/plant/erk_integrator.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

PlantInputs<double> supply() {
  PlantInputs<double> inputs{};
  inputs.u_dc = 530.0;
  inputs.tau_l = 5.0;
  return inputs;
}

ErrorControl at(double tolerance) {
  ErrorControl p{};
  p.relative_tolerance = p.flux_tolerance = p.speed_tolerance = p.angle_tolerance = tolerance;
  return p;
}

/// The flux after segments of 5 ms, which one step cannot cover.
SpaceVector<double> after_long_segments(PlantIntegrator<Plant>& integrator) {
  Plant plant{DrivePlantParameters<double>{}};
  plant.set_speed(120.0);
  PlantInputs<double> inputs = supply();
  for (const std::size_t vector : {1U, 2U, 7U, 3U}) {
    inputs.state = switch_states[vector];
    plant.set_inputs(inputs);
    EXPECT_TRUE(integrator.advance(plant, 5'000'000));
  }
  return plant.psi_s();
}

TEST(ErkIntegrator, ErrorFollowsTheTolerance) {
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
  const SpaceVector<double> reference = after_long_segments(fine);
  double before = 1.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    SCOPED_TRACE(tolerance);
    ErkIntegrator<Plant> erk{at(tolerance)};
    const double error = magnitude(after_long_segments(erk) - reference);
    EXPECT_LT(error, 20.0 * tolerance * magnitude(reference));
    EXPECT_LT(error, 0.2 * before);
    EXPECT_GT(error, 0.0);
    before = error;
  }
}

TEST(ErkIntegrator, ContinuesItsSolutionWhileNothingChanges) {
  const auto end = [](std::int64_t segment_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    PlantInputs<double> inputs = supply();
    inputs.state = switch_states[2];
    plant.set_inputs(inputs);
    ErkIntegrator<Plant> erk{at(1e-10)};
    for (std::int64_t t = 0; t < 10'000'000; t += segment_ns) EXPECT_TRUE(erk.advance(plant, segment_ns));
    return plant.psi_s();
  };
  EXPECT_LT(magnitude(end(25'000) - end(10'000'000)), 1e-8);
}

TEST(ErkIntegrator, AStateSetFromOutsideIsTakenUp) {
  Plant plant{DrivePlantParameters<double>{}};
  PlantInputs<double> inputs = supply();
  inputs.state = switch_states[0];
  inputs.tau_l = 0.0;
  plant.set_inputs(inputs);
  ErkIntegrator<Plant> erk;
  ASSERT_TRUE(erk.advance(plant, 25'000));
  plant.set_speed(42.0);
  ASSERT_TRUE(erk.advance(plant, 25'000));
  EXPECT_NEAR(plant.omega_m(), 42.0, 1e-9);
}

TEST(ErkIntegrator, FailureKeepsTheOldStateAndIsSilent) {
  ErrorControl parameters = at(1e-10);
  parameters.max_steps = 1;
  for (const SwitchState state :
       {switch_states[1], SwitchState{LegState::high, LegState::low, LegState::off}}) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_fluxes({0.5, 0.1}, {0.5, 0.1});
    PlantInputs<double> inputs = supply();
    inputs.state = state;
    plant.set_inputs(inputs);
    const Plant::State before = plant.state();
    ErkIntegrator<Plant> limited{parameters};
    testing::internal::CaptureStderr();
    EXPECT_FALSE(limited.advance(plant, 10'000'000));
    EXPECT_EQ(plant.state(), before);
    ErkIntegrator<Plant> erk;
    PlantInputs<double> bad = inputs;
    bad.tau_l = std::numeric_limits<double>::quiet_NaN();
    plant.set_inputs(bad);
    EXPECT_FALSE(erk.advance(plant, 25'000));
    EXPECT_EQ(plant.state(), before);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    plant.set_inputs(inputs);
    EXPECT_TRUE(erk.advance(plant, 25'000)) << "it recovers once the inputs are good";
  }
}

TEST(ErkIntegrator, BadParametersAreRefused) {
  EXPECT_THROW(ErkIntegrator<Plant>{at(std::numeric_limits<double>::quiet_NaN())}, std::runtime_error);
  ErrorControl parameters{};
  parameters.max_steps = 0;
  EXPECT_THROW(ErkIntegrator<Plant>{parameters}, std::runtime_error);
}

}  // namespace
}  // namespace sextant
