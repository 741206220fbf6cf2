#include "sextant/plant/plant_integrator.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

/// What every integrator promises.
template <class Integrator>
class PlantIntegratorTest : public ::testing::Test {};

using Integrators = ::testing::Types<FixedStepIntegrator<Plant>, ExactIntegrator<Plant>,
                                     CvodeIntegrator<Plant>, ErkIntegrator<Plant>>;
TYPED_TEST_SUITE(PlantIntegratorTest, Integrators);

TYPED_TEST(PlantIntegratorTest, NoTimeIsNoChange) {
  Plant plant{DrivePlantParameters<double>{}};
  plant.set_speed(3.0);
  const Plant::State before = plant.state();
  TypeParam integrator;
  EXPECT_TRUE(integrator.advance(plant, 0));
  EXPECT_EQ(plant.state(), before);
}

TYPED_TEST(PlantIntegratorTest, AStateSetFromOutsideIsTakenUp) {
  Plant plant{DrivePlantParameters<double>{}};
  PlantInputs<double> inputs = supply();
  inputs.state = switch_states[0];
  inputs.tau_l = 0.0;
  plant.set_inputs(inputs);
  TypeParam integrator;
  ASSERT_TRUE(integrator.advance(plant, 25'000));
  plant.set_speed(42.0);
  ASSERT_TRUE(integrator.advance(plant, 25'000));
  EXPECT_NEAR(plant.omega_m(), 42.0, 1e-9);
}

TYPED_TEST(PlantIntegratorTest, FailureKeepsTheOldStateAndIsSilent) {
  TypeParam integrator;
  for (const SwitchState state :
       {switch_states[1], SwitchState{LegState::high, LegState::low, LegState::off}}) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_fluxes({0.5, 0.1}, {0.5, 0.1});
    PlantInputs<double> inputs = supply();
    inputs.state = state;
    inputs.tau_l = std::numeric_limits<double>::quiet_NaN();
    plant.set_inputs(inputs);
    const Plant::State before = plant.state();
    testing::internal::CaptureStderr();
    EXPECT_FALSE(integrator.advance(plant, 50'000));
    EXPECT_EQ(plant.state(), before);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    inputs.tau_l = 5.0;
    plant.set_inputs(inputs);
    EXPECT_TRUE(integrator.advance(plant, 50'000)) << "it recovers once the inputs are good";
  }
}

/// The integrators that a microcontroller can run.
template <template <class> class Integrator>
void expect_float_follows_double() {
  Plant plant_d{DrivePlantParameters<double>{}};
  DrivePlant<float> plant_f{DrivePlantParameters<float>{}};
  Integrator<Plant> integrator_d;
  Integrator<DrivePlant<float>> integrator_f;
  const auto sequence = switching_sequence(4000, 9);
  ASSERT_TRUE(run(plant_d, integrator_d, sequence, supply()));
  ASSERT_TRUE(run(plant_f, integrator_f, sequence, supply<float>()));
  EXPECT_NEAR(double(plant_f.psi_s().alpha), plant_d.psi_s().alpha, 1e-3);
  EXPECT_NEAR(double(plant_f.psi_s().beta), plant_d.psi_s().beta, 1e-3);
  EXPECT_NEAR(double(plant_f.omega_m()), plant_d.omega_m(), 1e-2);
  // Gates off: the float currents die, too.
  ASSERT_TRUE(run(plant_f, integrator_f, std::vector<SwitchState>(800, gates_off), supply<float>()));
  EXPECT_LT(magnitude(plant_f.i_s()), 1e-3F);
}

TEST(FixedStepIntegrator, FloatPlantFollowsTheDoubleOne) {
  expect_float_follows_double<FixedStepIntegrator>();
}

TEST(ExactIntegrator, FloatPlantFollowsTheDoubleOne) {
  expect_float_follows_double<ExactIntegrator>();
}

}  // namespace
}  // namespace sextant
