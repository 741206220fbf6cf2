// A plant whose losses heat its thermal network, and whose resistances follow: currents and fluxes by closed
// forms, and energies.
#include "sextant/plant/plant_heating.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;

Plant metered(const DrivePlantParameters<>& p) {
  return Plant{p, Meter{}};
}

double energy(const Plant& plant, Meter::Index index) {
  return plant.state()[Plant::appended + int(index)];
}

/// Nothing flows, neither between the nodes nor to the ambient, that a run of seconds would show.
ThermalParameters<> insulated(double winding_c, double rotor_c) {
  ThermalParameters<> p;
  p.capacity = {50, 80, 300};
  p.to_ambient = {1e-9, 1e-9, 1e-9};
  p.start = {winding_c, rotor_c, 20};
  return p;
}

struct Integrator {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
};

std::vector<Integrator> every_integrator() {
  std::vector<Integrator> all;
  all.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>()});
  CvodeParameters stop;
  stop.at_switching = AtSwitching::stop;
  all.push_back({"cvode, stop", std::make_unique<CvodeIntegrator<Plant>>(stop)});
  all.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>()});
  all.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>()});
  all.push_back({"exact", std::make_unique<ExactIntegrator<Plant>>()});
  return all;
}

/// A shaft that stands, a leg high and two low.
PlantInputs<double> standing(double u_dc) {
  return {switch_states[1], u_dc, 0.0, true, 0.0};
}

// Constant voltage at standstill: i = 2/3 u_dc / R_s, with R_s = 0.435 Ω (1 + 0.00393 · 100) behind 20 mΩ.
TEST(PlantHeating, AHotWindingTakesLessCurrent) {
  DrivePlantParameters<> p;
  p.drops.slope_resistance = 0.02;
  for (auto& [name, integrator] : every_integrator()) {
    Plant plant = metered(p);
    const PlantHeating<Plant> heating{p, insulated(120, 20), plant};
    plant.set_inputs(standing(15));
    for (int n = 0; n < 400; ++n) ASSERT_TRUE(integrator->advance(plant, 10'000'000));
    EXPECT_NEAR(plant.i_s().alpha, 10 / (0.435 * 1.393 + 0.02), 1e-4) << name;
  }
}

// No stator current: psi_r = psi_0 e^(−t R_r/L_r), with R_r = 0.816 Ω (1 + 0.00403 · 130).
TEST(PlantHeating, AHotRotorLosesItsFluxSooner) {
  const DrivePlantParameters<> p;
  Plant plant = metered(p);
  const PlantHeating<Plant> heating{p, insulated(20, 150), plant};
  PlantInputs<double> inputs = standing(530);
  inputs.state = gates_off;
  plant.set_inputs(inputs);
  plant.set_fluxes(plant.machine().stator_flux({}, {1, 0}), {1, 0});
  FixedStepIntegrator<Plant> integrator;
  ASSERT_TRUE(integrator.advance(plant, 100'000'000));
  EXPECT_NEAR(plant.psi_r().alpha, std::exp(-0.1 * 0.816 * (1 + 0.00403 * 130) / p.machine.l_r()), 1e-7);
}

// Resistances that change within a run: current and flux against a solution by very short steps, which begins
// anew with each.
TEST(PlantHeating, EveryIntegratorTakesTheNewResistances) {
  const DrivePlantParameters<> p;
  const auto course = [&p](PlantIntegrator<Plant>& integrator) {
    Plant plant = metered(p);
    plant.set_speed(100);
    PlantInputs<double> inputs = supply();
    inputs.imposed_speed = true;  // at which the exact integrator keeps its transition
    plant.set_inputs(inputs);
    double factor = 1;
    for (const SwitchState state : switching_sequence(800, 5)) {
      factor += 5e-4;
      plant.set_resistances(0.435 * factor, 0.816 * factor);
      integrator.reset();
      plant.set_switch_state(state);
      EXPECT_TRUE(integrator.advance(plant, 25'000));
    }
    return plant;
  };
  FixedStepIntegrator<Plant> fine{{.max_step_ns = 500}};
  const Plant truth = course(fine);
  ASSERT_GT(magnitude(truth.psi_s()), 0.3);
  for (auto& [name, integrator] : every_integrator()) {
    const Plant found = course(*integrator);
    EXPECT_NEAR(found.tau_e(), truth.tau_e(), 5e-5 * std::abs(truth.tau_e())) << name;
    EXPECT_NEAR(magnitude(found.psi_s() - truth.psi_s()), 0, 1e-5) << name;
    EXPECT_NEAR(energy(found, Meter::stator_copper), energy(truth, Meter::stator_copper),
                5e-5 * energy(truth, Meter::stator_copper))
        << name;
  }
}

TEST(PlantHeating, TheSameResistancesChangeNothing) {
  const DrivePlantParameters<> p;
  Plant plant = metered(p);
  const auto jumps = plant.jumps();
  const auto revision = plant.revision();
  plant.set_resistances(p.machine.r_s, p.machine.r_r);
  EXPECT_EQ(plant.jumps(), jumps);
  EXPECT_EQ(plant.revision(), revision);
  plant.set_resistances(p.machine.r_s, 2 * p.machine.r_r);
  EXPECT_NE(plant.jumps(), jumps);
  EXPECT_NE(plant.revision(), revision);
}

// Iron loss follows R_r by R_R/R_e: as of a machine that has had the hot resistances from the beginning.
TEST(PlantHeating, AMachineWithIronLossIsThatOfTheHotResistances) {
  DrivePlantParameters<> p;
  p.iron_loss = {600, 900, 314};
  Plant heated = metered(p);
  heated.set_resistances(1.3 * p.machine.r_s, 1.4 * p.machine.r_r);
  p.machine.r_s *= 1.3;
  p.machine.r_r *= 1.4;
  Plant hot = metered(p);
  for (Plant* plant : {&heated, &hot}) {
    plant->set_fluxes({1.0, 0.3}, {0.9, 0.1});
    plant->set_speed(120);
    plant->set_inputs(supply());
  }
  Plant::State a, b;
  heated.derivative(heated.state(), a);
  hot.derivative(hot.state(), b);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-12 * b.cwiseAbs().maxCoeff());
  EXPECT_NEAR(heated.electrical_rate(), hot.electrical_rate(), 1e-12 * hot.electrical_rate());
  EXPECT_NEAR(heated.tau_e(), hot.tau_e(), 1e-12 * std::abs(hot.tau_e()));
}

/// Moves the plant in pieces of 25 us, as a power stage does.
void heat(Plant& plant, PlantHeating<Plant>& heating, PlantIntegrator<Plant>& integrator,
          const std::vector<SwitchState>& states) {
  for (const SwitchState state : states) {
    if (heating.step(plant)) integrator.reset();
    plant.set_switch_state(state);
    heating.begin_piece(plant);
    ASSERT_TRUE(integrator.advance(plant, 25'000));
    heating.end_piece(plant, 25'000);
  }
  // What the last, unfinished step has is not in the network.
  (void)heating.step(plant);
}

// Everything that a machine with iron loss and friction has lost is in its three nodes, while its resistances
// rise, and the meter's balance closes.
TEST(PlantHeating, WhatIsLostHeatsAndTheEnergyCloses) {
  DrivePlantParameters<> p;
  p.iron_loss = {600, 900, 314};
  p.viscous_friction = 0.05;
  ThermalParameters<> thermal = insulated(20, 30);
  thermal.capacity = {0.5, 0.8, 3};  // some kelvins
  thermal.step_ns = 1'000'000;
  for (const bool fixed : {true, false}) {
    Plant plant = metered(p);
    plant.set_speed(60);
    const double inertia_begin = 0.5 * p.machine.inertia * 60 * 60;
    PlantInputs<double> inputs = supply();
    plant.set_inputs(inputs);
    PlantHeating<Plant> heating{p, thermal, plant};
    std::unique_ptr<PlantIntegrator<Plant>> integrator = std::make_unique<FixedStepIntegrator<Plant>>();
    if (!fixed) integrator = std::make_unique<CvodeIntegrator<Plant>>();
    heat(plant, heating, *integrator, switching_sequence(4000, 3));
    const ThermalNodes<double> t = heating.temperatures();
    EXPECT_GT(t.winding - 20, 2);
    EXPECT_GT(t.rotor - 30, 2);
    const double copper_s = energy(plant, Meter::stator_copper);
    const double copper_r = energy(plant, Meter::rotor_copper);
    const double iron = energy(plant, Meter::iron);
    const double shaft = energy(plant, Meter::mechanical);
    EXPECT_NEAR(0.5 * (t.winding - 20), copper_s, 1e-7 * copper_s);
    EXPECT_NEAR(0.8 * (t.rotor - 30), copper_r, 1e-7 * copper_r);
    // The shaft's work less what speeds it up and what the load takes is friction.
    const double omega = plant.omega_m();
    const double friction = shaft - (0.5 * p.machine.inertia * omega * omega - inertia_begin) -
                            plant.inputs().tau_l * plant.theta_m();
    EXPECT_GT(friction, 1);
    EXPECT_NEAR(3 * (t.housing - 20), iron + friction, 5e-5 * (iron + friction));
    const double in = energy(plant, Meter::dc_link);
    EXPECT_NEAR(in, copper_s + copper_r + iron + shaft + plant.magnetic_energy(),
                1e-6 * (std::abs(in) + copper_s + copper_r));
    const double r_s = 0.435 * (1 + 0.00393 * (t.winding - 20));
    EXPECT_NEAR(plant.machine().parameters().r_s, r_s, 1e-12);
    EXPECT_NEAR(plant.machine().parameters().r_r, 0.816 * (1 + 0.00403 * (t.rotor - 20)), 1e-12);
  }
}

// A constant current through winding, slope and thresholds: the winding gets 3/2 R_s i² alone.
TEST(PlantHeating, WhatTheInverterLosesDoesNotHeatTheWinding) {
  DrivePlantParameters<> p;
  p.drops = {1.2, 0.05};
  ThermalParameters<> thermal = insulated(20, 20);
  thermal.capacity.winding = 1e6;  // it stays cold
  Plant plant = metered(p);
  plant.set_inputs(standing(20));
  FixedStepIntegrator<Plant> integrator;
  for (int n = 0; n < 400; ++n) ASSERT_TRUE(integrator.advance(plant, 10'000'000));
  PlantHeating<Plant> heating{p, thermal, plant};
  const double i = magnitude(plant.i_s());
  ASSERT_GT(i, 10);
  heat(plant, heating, integrator, std::vector<SwitchState>(8000, switch_states[1]));
  const double joules = 1.5 * 0.435 * i * i * 0.2;
  EXPECT_NEAR(1e6 * (heating.temperatures().winding - 20), joules, 1e-5 * joules);
}

// Constant current: the winding alone, heated by 3/2 R(ϑ) i², follows an exponential, of which the
// resistances lag by half a step: the error is of first order in it, and as large as documented.
TEST(PlantHeating, TheLagOfTheResistancesIsHalfAStep) {
  const auto error = [](std::int32_t step_ns) {
    const DrivePlantParameters<> p;
    ThermalParameters<> thermal = insulated(20, 20);
    thermal.capacity.winding = 20;
    thermal.step_ns = step_ns;
    Plant plant = metered(p);
    FixedStepIntegrator<Plant> integrator;
    PlantHeating<Plant> heating{p, thermal, plant};
    // The source follows the resistance, so that the current stays.
    constexpr double i = 20, seconds = 0.4;
    plant.set_fluxes({p.machine.l_s() * i, 0}, {p.machine.l_m * i, 0});
    for (int n = 0; n < int(seconds / 25e-6); ++n) {
      (void)heating.step(plant);
      plant.set_inputs(standing(1.5 * i * plant.machine().parameters().r_s));
      heating.begin_piece(plant);
      EXPECT_TRUE(integrator.advance(plant, 25'000));
      heating.end_piece(plant, 25'000);
    }
    (void)heating.step(plant);
    EXPECT_NEAR(magnitude(plant.i_s()), i, 1e-6);
    // 20 dϑ/dt = 3/2 i² 0.435 (1 + 0.00393 (ϑ − 20))
    const double power = 1.5 * i * i * 0.435;
    const double truth = std::expm1(0.00393 * power / 20 * seconds) / 0.00393;
    return std::abs(heating.temperatures().winding - 20 - truth);
  };
  const double coarse = error(20'000'000);
  const double fine = error(10'000'000);
  // Of the rise by R(ϑ): α P/C · (h/2 dϑ/dt) over 0.4 s.
  const double rate = 1.5 * 400 * 0.435 / 20;
  EXPECT_NEAR(fine, 0.00393 * rate * 0.4 * 0.5 * 0.01 * rate, 0.05 * fine);
  EXPECT_NEAR(coarse / fine, 2, 0.05);
}

/// The same behind a link whose voltage is a state: the meter is the second system.
TEST(PlantHeating, ReachesTheMeterBehindALink) {
  using Linked = DrivePlant<double, AppendedPair<DcLink<double>, Meter>>;
  const DrivePlantParameters<> p;
  const DcLinkParameters<> link{1e-3, 0.2};
  Linked plant{p, {DcLink<double>{link, p.machine.sigma_l_s(), 530}, Meter{}}};
  plant.set_resistances(2 * p.machine.r_s, 3 * p.machine.r_r);
  plant.set_fluxes({1.0, 0.3}, {0.9, 0.1});
  Linked::State dx;
  plant.derivative(plant.state(), dx);
  const int meter = Linked::size - Meter::size;
  const PlantQuantities<> q = plant.quantities_at(plant.state());
  EXPECT_NEAR(dx[meter + int(Meter::stator_copper)], 1.5 * 2 * p.machine.r_s * dot(q.i_s, q.i_s), 1e-9);
  EXPECT_NEAR(dx[meter + int(Meter::rotor_copper)], 1.5 * 3 * p.machine.r_r * dot(q.i_r, q.i_r), 1e-9);
}

}  // namespace
}  // namespace sextant
