#include "sextant/plant/variable_step_integrator.hpp"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/erk_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

template <class Integrator>
class VariableStepIntegratorTest : public ::testing::Test {
 protected:
  typename Integrator::Parameters parameters_{};
};

using Integrators = ::testing::Types<CvodeIntegrator<Plant>, ErkIntegrator<Plant>>;
TYPED_TEST_SUITE(VariableStepIntegratorTest, Integrators);

TYPED_TEST(VariableStepIntegratorTest, ContinuesItsSolutionWhileNothingChanges) {
  this->parameters_.relative_tolerance = 1e-10;
  this->parameters_.flux_tolerance = 1e-10;
  const auto end = [this](std::int64_t segment_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    PlantInputs<double> inputs = supply();
    inputs.state = switch_states[2];
    plant.set_inputs(inputs);
    TypeParam integrator{this->parameters_};
    for (std::int64_t t = 0; t < 10'000'000; t += segment_ns) {
      EXPECT_TRUE(integrator.advance(plant, segment_ns));
    }
    return plant.psi_s();
  };
  EXPECT_LT(magnitude(end(25'000) - end(10'000'000)), 1e-8);
}

TYPED_TEST(VariableStepIntegratorTest, TooManyStepsAreAFailureThatKeepsTheOldState) {
  this->parameters_.relative_tolerance = 1e-10;
  this->parameters_.flux_tolerance = 1e-10;
  this->parameters_.max_steps = 1;
  for (const SwitchState state :
       {switch_states[1], SwitchState{LegState::high, LegState::low, LegState::off}}) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_fluxes({0.5, 0.1}, {0.5, 0.1});
    PlantInputs<double> inputs = supply();
    inputs.state = state;
    plant.set_inputs(inputs);
    const Plant::State before = plant.state();
    TypeParam limited{this->parameters_};
    testing::internal::CaptureStderr();
    EXPECT_FALSE(limited.advance(plant, 10'000'000));
    EXPECT_EQ(plant.state(), before);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
}

TYPED_TEST(VariableStepIntegratorTest, BadParametersAreRefused) {
  this->parameters_.relative_tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(TypeParam{this->parameters_}, std::runtime_error);
  this->parameters_ = {};
  this->parameters_.max_steps = 0;
  EXPECT_THROW(TypeParam{this->parameters_}, std::runtime_error);
}

}  // namespace
}  // namespace sextant
