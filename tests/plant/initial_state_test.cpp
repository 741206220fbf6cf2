// A plant that begins turning and with flux, against the closed form of a machine whose stator is open:
//   psi_r = ψ e^(−t/τ_r) e^(j p omega_m t),   i_s = 0,   u_s = k_r (j p omega_m − 1/τ_r) psi_r
#include "sextant/plant/initial_state.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/driveline.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;
using Complex = std::complex<double>;

constexpr double u_dc = 530.0;
constexpr double flux = 0.6;
constexpr double speed = -90.0;

Complex complex(SpaceVector<> x) {
  return {x.alpha, x.beta};
}

DrivePlantParameters<> turning(double omega_m = speed, double psi = flux) {
  DrivePlantParameters<> p;
  p.initial = {omega_m, psi};
  return p;
}

/// e^((j p omega_m − 1/τ_r) t)
Complex decay(const InductionMachineParameters<>& m, double omega_m, double t) {
  return std::exp(Complex{-1.0 / m.tau_r(), m.pole_pairs * omega_m} * t);
}

template <class P>
std::vector<std::unique_ptr<PlantIntegrator<P>>> all_integrators() {
  std::vector<std::unique_ptr<PlantIntegrator<P>>> all;
  all.push_back(std::make_unique<FixedStepIntegrator<P>>());
  all.push_back(std::make_unique<ExactIntegrator<P>>());
  all.push_back(std::make_unique<ErkIntegrator<P>>());
  all.push_back(std::make_unique<CvodeIntegrator<P>>());
  return all;
}

TEST(InitialState, FluxAndInducedVoltageDecayAsThoseOfAnOpenStator) {
  for (const auto& integrator : all_integrators<Plant>()) {
    Plant plant{turning()};
    const InductionMachineParameters<>& m = plant.machine().parameters();
    plant.set_inputs({.u_dc = u_dc});
    for (int n = 0; n <= 200; ++n) {
      const double t = n * 1e-3;
      const Complex psi_r = flux * decay(m, speed, t);
      const Complex u_s = m.k_r() * Complex{-1.0 / m.tau_r(), m.pole_pairs * speed} * psi_r;
      ASSERT_LT(std::abs(complex(plant.psi_r()) - psi_r), 1e-6) << n;
      ASSERT_LT(std::abs(complex(plant.psi_s()) - m.k_r() * psi_r), 1e-6) << n;
      ASSERT_LT(std::abs(complex(plant.u_s()) - u_s), 1e-4 * std::abs(u_s)) << n;
      ASSERT_LT(magnitude(plant.i_s()), 1e-4) << n;
      ASSERT_NEAR(plant.omega_m(), speed, 1e-9) << n;
      ASSERT_TRUE(integrator->advance(plant, 1'000'000));
    }
  }
}

// Of two lines the largest voltage is √3 |u_s|: above the link's the diodes carry a current, which brakes.
TEST(InitialState, DiodesConductWhereTheInducedVoltageIsAboveTheLink) {
  for (const double share : {0.98, 1.05}) {
    const InductionMachineParameters<> m;
    const double rate = share * u_dc / (std::sqrt(3.0) * m.k_r() * 1.1);
    const double omega_m = std::sqrt(rate * rate - 1.0 / (m.tau_r() * m.tau_r())) / m.pole_pairs;
    Plant plant{turning(omega_m, 1.1)};
    plant.set_inputs({.u_dc = u_dc});
    FixedStepIntegrator<Plant> integrator;
    double largest = 0.0;
    for (int n = 0; n < 100; ++n) {
      ASSERT_TRUE(integrator.advance(plant, 50'000));
      largest = std::max(largest, magnitude(plant.i_s()));
    }
    if (share < 1.0) {
      EXPECT_LT(largest, 1e-4);
      EXPECT_NEAR(plant.omega_m(), omega_m, 1e-9);
    } else {
      EXPECT_GT(largest, 0.1);
      EXPECT_LT(plant.omega_m(), omega_m - 1e-3);
    }
  }
}

TEST(InitialState, FrictionBrakesTheFreeShaft) {
  DrivePlantParameters<> p = turning(50.0, 0.0);
  p.viscous_friction = 0.02;
  for (const auto& integrator : all_integrators<Plant>()) {
    Plant plant{p};
    plant.set_inputs({.u_dc = u_dc});
    for (int n = 0; n < 100; ++n) ASSERT_TRUE(integrator->advance(plant, 1'000'000));
    EXPECT_NEAR(plant.omega_m(), 50.0 * std::exp(-0.02 * 0.1 / p.machine.inertia), 1e-5);
    const double turned = 50.0 * p.machine.inertia / 0.02 * (1.0 - std::exp(-0.02 * 0.1 / p.machine.inertia));
    EXPECT_NEAR(plant.theta_m(), turned, 1e-5);
  }
}

// Without saturation 3/2 i_d² L_m²/(2 L_r) of i_d = ψ/L_m, and what is in psi_s adds nothing without current.
TEST(InitialState, TheFieldHasTheEnergyOfTheRotorsCurrent) {
  const Plant plant{turning()};
  const InductionMachineParameters<>& m = plant.machine().parameters();
  EXPECT_NEAR(plant.magnetic_energy(), 0.75 * flux * flux / m.l_r(), 1e-12);
}

TEST(InitialState, ASaturatedMachineBeginsWithoutStatorCurrent) {
  DrivePlantParameters<> p = turning(speed, 1.2);
  p.saturation.knee = 0.9;
  const Plant plant{p};
  EXPECT_LT(magnitude(plant.i_s()), 1e-9);
  EXPECT_LT(plant.psi_s().alpha, 0.99 * p.machine.k_r() * 1.2);
}

// Both masses turn alike, so that the shaft carries no torque until something brakes one of them.
TEST(InitialState, ALoadBehindADrivelineTurnsWithTheMotor) {
  using Shaft = Driveline<double>;
  using Shafted = DrivePlant<double, Shaft>;
  const DrivePlantParameters<> p = turning(40.0, 0.0);
  const Shaft shaft{
      {.inertia = 0.2, .stiffness = 800.0, .damping = 0.5, .gear_ratio = 3.0}, p.machine.inertia, 0};
  for (const auto& integrator : all_integrators<Shafted>()) {
    Shafted plant{p, shaft};
    plant.set_inputs({.u_dc = u_dc});
    for (int n = 0; n < 50; ++n) ASSERT_TRUE(integrator->advance(plant, 1'000'000));
    const auto y = Shafted::states_of<Shaft>(plant.state());
    EXPECT_NEAR(plant.omega_m(), 40.0, 1e-9);
    EXPECT_NEAR(y[Shaft::load_speed], 40.0, 1e-9);
    EXPECT_NEAR(y[Shaft::twist], 0.0, 1e-12);
    EXPECT_NEAR(plant.theta_m(), 2.0, 1e-9);
  }
}

TEST(InitialState, WhatIsNoStateIsRefused) {
  EXPECT_EQ(InitialState<>{}.validate(), nullptr);
  EXPECT_NE((InitialState<>{std::numeric_limits<double>::infinity(), 0.0}.validate()), nullptr);
  EXPECT_NE((InitialState<>{0.0, -0.1}.validate()), nullptr);
  EXPECT_NE((InitialState<>{0.0, std::numeric_limits<double>::quiet_NaN()}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
