#include "sextant/plant/energy_meter.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;

Plant metered_plant() {
  const DrivePlantParameters<double> parameters{};
  return Plant{parameters, Meter{}};
}

void expect_balance(const Plant& plant, double initial_magnetic, double relative) {
  const auto energy = [&](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
  const double in = energy(Meter::dc_link);
  const double out = energy(Meter::stator_copper) + energy(Meter::rotor_copper) + energy(Meter::mechanical) +
                     plant.magnetic_energy() - initial_magnetic;
  const double throughput = std::abs(in) + energy(Meter::stator_copper) + energy(Meter::rotor_copper);
  EXPECT_GT(throughput, 1.0);
  EXPECT_NEAR(in, out, relative * throughput);
}

/// A switching run, then gates off at speed, then one leg alone off.
void run_all(Plant& plant, PlantIntegrator<Plant>& integrator) {
  PlantInputs<double> inputs = supply();
  ASSERT_TRUE(run(plant, integrator, switching_sequence(4000, 11), inputs));
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(200, gates_off), inputs));
  std::vector<SwitchState> open_phase = switching_sequence(2000, 12);
  for (SwitchState& state : open_phase) state = {state.a(), LegState::off, state.c()};
  ASSERT_TRUE(run(plant, integrator, open_phase, inputs));
}

TEST(EnergyMeter, BalancesWithTheFixedStep) {
  Plant plant = metered_plant();
  FixedStepIntegrator<Plant> integrator;
  run_all(plant, integrator);
  expect_balance(plant, 0.0, 1e-6);
}

TEST(EnergyMeter, BalancesWithCvode) {
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    parameters.relative_tolerance = 1e-9;
    parameters.flux_tolerance = 1e-11;
    Plant plant = metered_plant();
    CvodeIntegrator<Plant> integrator{parameters};
    run_all(plant, integrator);
    expect_balance(plant, 0.0, 1e-6);
  }
}

TEST(EnergyMeter, BalancesWhileRectifying) {
  Plant plant = metered_plant();
  plant.set_fluxes({1.1, 0.0}, {1.1, 0.0});
  plant.set_speed(250.0);
  PlantInputs<double> inputs{};
  inputs.u_dc = 530.0;
  plant.set_inputs(inputs);
  const double initial = plant.magnetic_energy();
  FixedStepIntegrator<Plant> integrator;
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(2000, gates_off), inputs));
  EXPECT_LT(plant.state()[Plant::appended + int(Meter::dc_link)], -1.0);
  expect_balance(plant, initial, 1e-6);
}

}  // namespace
}  // namespace sextant
