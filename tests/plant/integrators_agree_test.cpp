// All integrators on one switching sequence: driven, with open legs and without any gate.

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;

struct Contestant {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
  double flux_error;    // [Wb]
  double energy_error;  // unaccounted part of what flowed [-]
};

std::vector<Contestant> contestants() {
  CvodeParameters tight{};
  tight.relative_tolerance = 1e-10;
  tight.flux_tolerance = 1e-12;
  ErrorControl erk{};
  erk.relative_tolerance = 1e-10;
  erk.flux_tolerance = 1e-12;
  std::vector<Contestant> list;
  list.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>(tight), 1e-6, 1e-7});
  list.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>(), 1e-6, 1e-7});
  // Its meters go by the trapezoidal rule.
  list.push_back({"exact", std::make_unique<ExactIntegrator<Plant>>(), 1e-6, 2e-4});
  list.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>(erk), 1e-6, 1e-7});
  return list;
}

Plant start() {
  const DrivePlantParameters<double> parameters{};
  return Plant{parameters, Meter{}};
}

/// Driven, then gates off, driven again, one leg open, gates off at a speed at which the machine rectifies.
void go(Plant& plant, PlantIntegrator<Plant>& integrator) {
  PlantInputs<double> inputs = supply();
  ASSERT_TRUE(run(plant, integrator, switching_sequence(2000, 11), inputs));
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(100, gates_off), inputs));
  ASSERT_TRUE(run(plant, integrator, switching_sequence(1500, 13), inputs));
  std::vector<SwitchState> open_phase = switching_sequence(500, 12);
  for (SwitchState& state : open_phase) state = {state.a(), LegState::off, state.c()};
  ASSERT_TRUE(run(plant, integrator, open_phase, inputs));
  inputs.u_dc = 60.0;
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(400, gates_off), inputs));
}

double energy(const Plant& plant, Meter::Index i) {
  return plant.state()[Plant::appended + int(i)];
}

TEST(Integrators, AgreeThroughSwitchingAndDiodeEvents) {
  Plant reference = start();
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
  go(reference, fine);
  ASSERT_GT(magnitude(reference.psi_r()), 0.05);
  for (const Contestant& c : contestants()) {
    SCOPED_TRACE(c.name);
    Plant plant = start();
    go(plant, *c.integrator);
    EXPECT_LT(magnitude(plant.psi_s() - reference.psi_s()), c.flux_error);
    EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), c.flux_error);
    EXPECT_NEAR(plant.omega_m(), reference.omega_m(), 1e-5);
    EXPECT_NEAR(plant.theta_m(), reference.theta_m(), 1e-5);
    EXPECT_EQ(plant.inverter().ties(), reference.inverter().ties());
  }
}

TEST(Integrators, KeepTheBalanceOfEnergy) {
  for (const Contestant& c : contestants()) {
    SCOPED_TRACE(c.name);
    Plant plant = start();
    go(plant, *c.integrator);
    const double copper = energy(plant, Meter::stator_copper) + energy(plant, Meter::rotor_copper);
    const double in = energy(plant, Meter::dc_link);
    const double out = copper + energy(plant, Meter::mechanical) + plant.magnetic_energy();
    EXPECT_GT(copper, 1.0);
    EXPECT_NEAR(in, out, c.energy_error * (std::abs(in) + copper));
  }
}

}  // namespace
}  // namespace sextant
