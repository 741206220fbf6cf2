#include "sextant/plant/erk_integrator.hpp"

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

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

}  // namespace
}  // namespace sextant
