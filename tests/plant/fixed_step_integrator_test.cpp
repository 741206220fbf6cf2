#include "sextant/plant/fixed_step_integrator.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"

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
  // At 25 µs the error is too near to rounding to show the order, above 76 µs this machine gets shorter
  // steps.
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
  const SpaceVector<double> exact = end(4'000);
  const double coarse = magnitude(end(64'000) - exact);
  const double fine = magnitude(end(32'000) - exact);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.3);
}

TEST(FixedStepIntegrator, OneStepAPeriodIsEnough) {
  EXPECT_LT(magnitude(flux_after_run(25'000) - flux_after_run(2'500)), 1e-8);
}

/// Largest difference of the torque after each period of a switching sequence, by the peak of the torque.
template <class Integrator>
double torque_error(const DrivePlantParameters<double>& parameters, double u_dc) {
  using Plant = DrivePlant<double>;
  PlantInputs<double> inputs = supply();
  inputs.u_dc = u_dc;
  inputs.tau_l = 0.0;
  Plant plant{parameters};
  Plant reference{parameters};
  Integrator integrator;
  ErkIntegrator<Plant> erk{{.relative_tolerance = 1e-12, .flux_tolerance = 1e-14}};
  double error = 0.0;
  double peak = 0.0;
  for (const SwitchState state : switching_sequence(2000, 3)) {
    EXPECT_TRUE(run(plant, integrator, {state}, inputs));
    EXPECT_TRUE(run(reference, erk, {state}, inputs));
    error = std::max(error, std::abs(plant.tau_e() - reference.tau_e()));
    peak = std::max(peak, std::abs(reference.tau_e()));
  }
  return error / peak;
}

/// One step of 25 µs is 2.7 times its fastest time constant, at the edge of the method's stability.
DrivePlantParameters<double> stiff_machine() {
  DrivePlantParameters<double> p{};
  p.machine = {
      .r_s = 2.0, .r_r = 2.0, .l_ls = 18.5e-6, .l_lr = 18.5e-6, .l_m = 0.0247, .inertia = p.machine.inertia};
  return p;
}

/// Torque and speed oscillate against each other with 1900 1/s.
DrivePlantParameters<double> light_shaft() {
  DrivePlantParameters<double> p{};
  p.machine.inertia = 1e-4;
  return p;
}

TEST(BoundedTimeIntegrators, AStiffMachineGetsShorterSteps) {
  using Plant = DrivePlant<double>;
  EXPECT_GT(25e-6 * Plant{stiff_machine()}.electrical_rate(), 2.6);
  EXPECT_LT(torque_error<FixedStepIntegrator<Plant>>(stiff_machine(), 57.0), 1e-6);
  EXPECT_LT(torque_error<ExactIntegrator<Plant>>(stiff_machine(), 57.0), 1e-6);
}

TEST(BoundedTimeIntegrators, ALightShaftGetsShorterSteps) {
  using Plant = DrivePlant<double>;
  EXPECT_LT(torque_error<FixedStepIntegrator<Plant>>(light_shaft(), 530.0), 1e-6);
  EXPECT_LT(torque_error<ExactIntegrator<Plant>>(light_shaft(), 530.0), 1e-6);
}

TEST(BoundedTimeIntegrators, AStepThatIsTooLongForTheMachineIsDivided) {
  using Plant = DrivePlant<double>;
  const auto end = [](std::int32_t max_step_ns) {
    Plant plant{DrivePlantParameters<double>{}};
    plant.set_speed(120.0);
    PlantInputs<double> inputs = supply();
    inputs.state = switch_states[1];
    plant.set_inputs(inputs);
    FixedStepIntegrator<Plant> integrator{FixedStepParameters{max_step_ns}};
    EXPECT_TRUE(integrator.advance(plant, 10'000'000));
    return plant.psi_s();
  };
  EXPECT_LT(magnitude(end(100'000'000) - end(2'500)), 1e-6 * magnitude(end(2'500)));
}

TEST(BoundedTimeIntegrators, AMachineWithoutEndOfStepsIsAFailure) {
  using Plant = DrivePlant<double>;
  DrivePlantParameters<double> p = stiff_machine();
  p.machine.l_ls = p.machine.l_lr = 1e-15;
  Plant plant{p};
  PlantInputs<double> inputs = supply();
  inputs.state = switch_states[1];
  plant.set_inputs(inputs);
  const Plant::State before = plant.state();
  EXPECT_FALSE(FixedStepIntegrator<Plant>{}.advance(plant, switching_period_ns));
  EXPECT_EQ(plant.state(), before);
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
