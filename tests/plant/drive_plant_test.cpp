#include "sextant/plant/drive_plant.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

Plant spinning_plant(double psi, double omega_m, SwitchState state = gates_off) {
  Plant plant{DrivePlantParameters<double>{}};
  PlantInputs<double> inputs{};
  inputs.state = state;
  inputs.u_dc = 530.0;
  inputs.imposed_speed = true;
  plant.set_inputs(inputs);
  const SpaceVector<double> psi_r{psi, 0.0};
  plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
  plant.set_speed(omega_m);
  return plant;
}

TEST(DrivePlant, NoSpeedBringsTheFluxBeyondWhatTheLinkCanFeed) {
  // Direct current comes next to it, nothing beyond, whatever the shaft is made to do.
  std::mt19937 random{7};
  DrivePlantParameters<double> parameters{};
  parameters.machine.r_s = 5.0;
  parameters.machine.r_r = 5.0;
  Plant plant{parameters};
  FixedStepIntegrator<Plant> integrator;
  PlantInputs<double> inputs{switch_states[1], 530.0, 0.0, true, 0.0};
  for (int n = 0; n < 400; ++n) {
    if (n >= 100) {
      plant.set_speed(std::uniform_real_distribution{-2000.0, 2000.0}(random));
      inputs.state = switch_states[random() % 8];
      inputs.speed_slope = std::uniform_real_distribution{-1e6, 1e6}(random);
    }
    plant.set_inputs(inputs);
    ASSERT_TRUE(integrator.advance(plant, 1'000'000));
    ASSERT_TRUE(plant.is_reachable()) << n;
    if (n == 99) {
      const double largest = 2.0 / 3.0 * 530.0 * parameters.machine.l_s() / parameters.machine.r_s;
      EXPECT_NEAR(magnitude(plant.psi_s()), largest, 0.07 * largest);
    }
  }
}

TEST(DrivePlant, AFluxThatTheLinkCannotFeedIsNotReachable) {
  Plant plant = spinning_plant(1.0, 0.0, switch_states[1]);
  EXPECT_TRUE(plant.is_reachable());
  const InductionMachineParameters<double> m{};
  const double largest = 2.0 / 3.0 * 530.0 * m.l_s() / m.r_s;
  plant.set_fluxes({0.0, largest}, {});
  EXPECT_TRUE(plant.is_reachable());
  plant.set_fluxes({0.0, 1.01 * largest}, {});
  EXPECT_FALSE(plant.is_reachable());
  plant.set_fluxes({}, {});
  plant.set_speed(INFINITY);
  EXPECT_FALSE(plant.is_reachable());
}

TEST(DrivePlant, ParametersAreChecked) {
  DrivePlantParameters<double> p{};
  EXPECT_EQ(p.validate(), nullptr);
  p.viscous_friction = -1.0;
  EXPECT_NE(p.validate(), nullptr);
  p = {};
  p.machine.inertia = 0.0;
  EXPECT_NE(p.validate(), nullptr);
  p = {};
  p.road_load.quadratic_drag = -1.0;
  EXPECT_NE(p.validate(), nullptr);
}

TEST(DrivePlant, JacobianIsTheDerivativeOfTheRightHandSide) {
  constexpr unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> uniform{-1, 1};
  DrivePlantParameters<double> parameters{};
  parameters.viscous_friction = 0.02;
  for (int n = 0; n < 300; ++n) {
    SCOPED_TRACE(n);
    Plant plant{parameters};
    Plant::State x;
    x << uniform(random), uniform(random), uniform(random), uniform(random), 150 * uniform(random),
        uniform(random);
    if (n % 3 == 0) x.head<2>() = parameters.machine.k_r() * x.segment<2>(2);
    plant.set_state(x);
    const auto leg = [&] { return LegState(random() % 3U); };
    PlantInputs<double> inputs{};
    inputs.state = {leg(), leg(), leg()};
    inputs.u_dc = 530.0;
    inputs.tau_l = 4.0;
    inputs.imposed_speed = n % 5 == 0;
    plant.set_inputs(inputs);
    x = plant.state();
    Plant::Jacobian analytic;
    plant.jacobian(x, analytic);
    for (int c = 0; c < Plant::size; ++c) {
      // The equations are quadratic, so that a central difference is exact but for rounding.
      const double h = 1e-2;
      Plant::State ahead, behind;
      plant.derivative(x + h * Plant::State::Unit(c), ahead);
      plant.derivative(x - h * Plant::State::Unit(c), behind);
      const Plant::State numeric = (ahead - behind) / (2 * h);
      EXPECT_LT((numeric - analytic.col(c)).cwiseAbs().maxCoeff(),
                1e-8 * (1 + numeric.cwiseAbs().maxCoeff()));
    }
  }
}

TEST(DrivePlant, JacobianKnowsTheRoadLoad) {
  constexpr unsigned seed = 4;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> uniform{-1, 1};
  DrivePlantParameters<double> parameters{};
  parameters.viscous_friction = 0.02;
  parameters.road_load = {.quadratic_drag = 0.03,
                          .rolling_torque = 2,
                          .rolling_speed = 0.7,
                          .grade_torque = 3,
                          .coupled_inertia = 0.5};
  for (int n = 0; n < 300; ++n) {
    SCOPED_TRACE(n);
    Plant plant{parameters};
    Plant::State x;
    // Near standstill too, where the rolling torque bends.
    x << uniform(random), uniform(random), uniform(random), uniform(random),
        (n % 2 == 0 ? 150 : 3) * uniform(random), uniform(random);
    PlantInputs<double> inputs{};
    inputs.state = switch_states[1];
    inputs.u_dc = 530.0;
    inputs.imposed_speed = n % 5 == 0;
    plant.set_inputs(inputs);
    Plant::Jacobian analytic;
    plant.jacobian(x, analytic);
    for (int c = 0; c < Plant::size; ++c) {
      const double h = c == Plant::omega ? 1e-4 : 1e-2;
      Plant::State ahead, behind;
      plant.derivative(x + h * Plant::State::Unit(c), ahead);
      plant.derivative(x - h * Plant::State::Unit(c), behind);
      const Plant::State numeric = (ahead - behind) / (2 * h);
      EXPECT_LT((numeric - analytic.col(c)).cwiseAbs().maxCoeff(),
                1e-7 * (1 + numeric.cwiseAbs().maxCoeff()));
    }
    EXPECT_EQ(analytic(Plant::omega, Plant::omega) == 0.0, inputs.imposed_speed);
  }
}

TEST(DrivePlant, AnImposedSpeedTakesNoNoticeOfTheRoad) {
  DrivePlantParameters<double> parameters{};
  parameters.road_load = {.grade_torque = 50, .coupled_inertia = 1};
  Plant plant{parameters};
  EXPECT_EQ(plant.tau_road(), 50.0);
  PlantInputs<double> inputs{};
  inputs.imposed_speed = true;
  inputs.speed_slope = 10.0;
  plant.set_inputs(inputs);
  EXPECT_EQ(plant.tau_road(), 0.0);
  FixedStepIntegrator<Plant> integrator;
  ASSERT_TRUE(integrator.advance(plant, 1'000'000));
  EXPECT_NEAR(plant.omega_m(), 0.01, 1e-12);
  inputs.imposed_speed = false;
  plant.set_inputs(inputs);
  EXPECT_EQ(plant.tau_road(), 50.0);
}

TEST(DrivePlant, LoadTorqueOpposesPositiveRotation) {
  DrivePlantParameters<double> parameters{};
  parameters.viscous_friction = 0.01;
  Plant plant{parameters};
  PlantInputs<double> inputs{};
  inputs.state = switch_states[0];
  inputs.u_dc = 530.0;
  inputs.tau_l = 2.0;
  plant.set_inputs(inputs);
  FixedStepIntegrator<Plant> integrator;
  for (int n = 0; n < 40000; ++n) ASSERT_TRUE(integrator.advance(plant, 25'000));
  const double tau = parameters.machine.inertia / parameters.viscous_friction;
  EXPECT_NEAR(plant.omega_m(), -200.0 * (1 - std::exp(-1.0 / tau)), 1e-6);
}

TEST(DrivePlant, ImposedSpeedFollowsItsSlope) {
  Plant plant = spinning_plant(1.0, 20.0, switch_states[1]);
  PlantInputs<double> inputs = plant.inputs();
  inputs.speed_slope = 100.0;
  plant.set_inputs(inputs);
  FixedStepIntegrator<Plant> integrator;
  for (int n = 0; n < 400; ++n) ASSERT_TRUE(integrator.advance(plant, 25'000));
  EXPECT_NEAR(plant.omega_m(), 21.0, 1e-9);
  EXPECT_NEAR(plant.theta_m(), 0.205, 1e-9);
}

TEST(DrivePlant, RevisionChangesWithInputsOnly) {
  Plant plant = spinning_plant(1.0, 20.0, switch_states[1]);
  FixedStepIntegrator<Plant> integrator;
  const auto revision = plant.revision();
  ASSERT_TRUE(integrator.advance(plant, 25'000));
  plant.set_inputs(plant.inputs());
  EXPECT_EQ(plant.revision(), revision);
  PlantInputs<double> inputs = plant.inputs();
  inputs.tau_l = 1.0;
  plant.set_inputs(inputs);
  EXPECT_NE(plant.revision(), revision);
}

TEST(DrivePlant, GatesOffAtSpeedLeavesOnlyTheRotorFlux) {
  Plant plant = spinning_plant(0.6, 100.0, switch_states[2]);
  FixedStepIntegrator<Plant> integrator;
  ASSERT_TRUE(integrator.advance(plant, 500'000));
  ASSERT_GT(magnitude(plant.i_s()), 5.0);
  PlantInputs<double> inputs = plant.inputs();
  inputs.state = gates_off;
  plant.set_inputs(inputs);
  int periods = 0;
  while (floating_legs(plant.inverter().ties()) < 3) {
    ASSERT_TRUE(integrator.advance(plant, 25'000));
    ASSERT_LT(++periods, 400) << "the currents must die within 10 ms";
  }
  EXPECT_GT(periods, 1);
  const double start = magnitude(plant.psi_r());
  const double tau_r = plant.machine().parameters().tau_r();
  for (int n = 1; n <= 4000; ++n) {
    ASSERT_TRUE(integrator.advance(plant, 25'000));
    ASSERT_LT(magnitude(plant.i_s()), 1e-9);
    ASSERT_EQ(plant.i_dc(), 0.0);
  }
  EXPECT_NEAR(magnitude(plant.psi_r()) / start, std::exp(-0.1 / tau_r), 1e-7);
  EXPECT_NEAR(plant.tau_e(), 0.0, 1e-9);
}

TEST(DrivePlant, LineEmfAboveTheLinkIsRectified) {
  Plant plant = spinning_plant(1.1, 250.0);
  const double emf = magnitude(plant.u_s());
  ASSERT_GT(std::numbers::sqrt3 * emf, 530.0);
  FixedStepIntegrator<Plant> integrator;
  double charge = 0.0;
  double braking = 0.0;
  for (int n = 0; n < 400; ++n) {
    ASSERT_TRUE(integrator.advance(plant, 25'000));
    ASSERT_LE(plant.i_dc(), 1e-3) << "diodes cannot draw from the link";
    charge += plant.i_dc() * 25e-6;
    braking += plant.tau_e() * 25e-6;
  }
  EXPECT_LT(charge, -0.01);
  EXPECT_LT(braking, -0.01);
  // Rectification ends by itself when the rotor flux has decayed.
  for (int n = 0; n < 40000; ++n) ASSERT_TRUE(integrator.advance(plant, 25'000));
  EXPECT_EQ(floating_legs(plant.inverter().ties()), 3);
  EXPECT_LT(magnitude(plant.i_s()), 1e-12);
}

TEST(DrivePlant, OneLegOffIsASinglePhaseMachine) {
  Plant plant = spinning_plant(0.0, 0.0, {LegState::high, LegState::low, LegState::off});
  FixedStepIntegrator<Plant> integrator;
  // At standstill and without flux: current along a−b only, u_dc across two phases in series.
  ASSERT_TRUE(integrator.advance(plant, 100'000));
  const ThreePhase<double> i = plant.i_abc();
  EXPECT_NEAR(i.c, 0.0, 1e-9);
  EXPECT_NEAR(i.a, -i.b, 1e-9);
  const double l = plant.machine().parameters().sigma_l_s();
  EXPECT_NEAR(i.a, 530.0 / (2 * l) * 100e-6, 0.03 * i.a);
  EXPECT_NEAR(plant.tau_e(), 0.0, 1e-9);
  EXPECT_NEAR(plant.inverter().leg_potentials({})[2], 265.0, 1.0);
}

TEST(DrivePlant, CurrentOfASwitchedOffLegReachesExactlyZero) {
  Plant plant = spinning_plant(0.0, 0.0, switch_states[1]);
  FixedStepIntegrator<Plant> integrator;
  ASSERT_TRUE(integrator.advance(plant, 200'000));
  PlantInputs<double> inputs = plant.inputs();
  inputs.state = {LegState::off, LegState::low, LegState::low};
  plant.set_inputs(inputs);
  EXPECT_EQ(plant.inverter().ties()[0], LegTie::low);
  inputs.state = {LegState::low, LegState::high, LegState::off};
  plant.set_inputs(inputs);
  EXPECT_EQ(plant.inverter().ties()[2], LegTie::high);
  int periods = 0;
  while (plant.inverter().ties()[2] == LegTie::high) {
    ASSERT_TRUE(integrator.advance(plant, 25'000));
    ASSERT_LT(++periods, 400);
  }
  EXPECT_NEAR(plant.i_abc().c, 0.0, 1e-9);
  EXPECT_GT(std::abs(plant.i_abc().a), 0.1);
}

}  // namespace
}  // namespace sextant
