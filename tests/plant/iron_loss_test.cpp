// The induction machine with iron loss, against its equivalent circuit in steady state, its law and energy.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/runge_kutta.hpp"

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;
using Parameters = IronLossParameters<>;
using Complex = std::complex<double>;

constexpr double fifty_hz = 314.159265358979;  // [rad/s]

/// Of 2.2 kW at 50 Hz and half of the flux of these runs, some 2 % of the power each.
const Parameters both{600.0, 900.0, fifty_hz};
const std::vector<Parameters> cases{
    {500.0, 0.0, fifty_hz}, {0.0, 400.0, fifty_hz}, both, {60.0, 90.0, 2 * fifty_hz}, {1e5, 30.0, fifty_hz}};

DrivePlantParameters<> parameters_with(const Parameters& iron_loss,
                                       const SaturationParameters<>& saturation = {}) {
  DrivePlantParameters<> p;
  p.iron_loss = iron_loss;
  p.saturation = saturation;
  return p;
}
Plant plant_of(const DrivePlantParameters<>& p) {
  return Plant{p, Meter{}};
}
Plant plant_with(const Parameters& iron_loss) {
  return plant_of(parameters_with(iron_loss));
}

std::string problem(const char* text) {
  return text == nullptr ? "" : text;
}

TEST(IronLoss, ParametersAreChecked) {
  for (const Parameters& p : cases) EXPECT_EQ(problem(parameters_with(p).validate()), "");
  EXPECT_EQ(problem(Parameters{}.validate()), "");
  EXPECT_FALSE(Parameters{}.acts());
  EXPECT_THAT(problem(parameters_with({-1, 0, 1}).validate()), ::testing::HasSubstr("eddy"));
  EXPECT_THAT(problem(parameters_with({NAN, 0, 1}).validate()), ::testing::HasSubstr("eddy"));
  EXPECT_THAT(problem(parameters_with({0, -1, 1}).validate()), ::testing::HasSubstr("hysteresis"));
  EXPECT_THAT(problem(parameters_with({0, INFINITY, 1}).validate()), ::testing::HasSubstr("hysteresis"));
  EXPECT_THAT(problem(parameters_with({0, 100, 0}).validate()), ::testing::HasSubstr("frequency"));
}

/// The machine whose hysteresis takes more current than its flux would be a magnet.
TEST(IronLoss, AHysteresisThatHoldsTheFluxIsRefused) {
  const InductionMachineParameters<> m;
  const double reactance = fifty_hz * m.k_r() * m.l_m;
  EXPECT_EQ(problem(parameters_with({0, 1.01 * reactance, fifty_hz}).validate()), "");
  const char* const flux_would_stay = "flux would stay without a current";
  EXPECT_THAT(problem(parameters_with({0, 0.99 * reactance, fifty_hz}).validate()),
              ::testing::HasSubstr(flux_would_stay));
  // Three times the inductance at small fluxes.
  const SaturationParameters<> saturation{1.0, 2, std::sqrt(2.0)};
  EXPECT_EQ(problem(parameters_with({0, 3.01 * reactance, fifty_hz}, saturation).validate()), "");
  EXPECT_THAT(problem(parameters_with({0, 2.99 * reactance, fifty_hz}, saturation).validate()),
              ::testing::HasSubstr(flux_would_stay));
}

struct SteadyState {
  Complex psi_s{}, psi_r{};  // [Wb]
  Complex i_s{}, i_r{};      // [A]
  double torque{};           // [N·m]
  double loss{};             // of the iron [W]
};

/// The inverse-Γ circuit at a frequency, with the resistance of the iron beside magnetising inductance and
/// rotor; all values as phasors of amplitude-invariant space vectors.
SteadyState circuit(const InductionMachineParameters<>& m, const Parameters& p, Complex u_s, double omega_s,
                    double omega_r) {
  const Complex j{0, 1};
  const double k_r = m.l_m / (m.l_lr + m.l_m);
  const double l_sigma = m.l_ls + m.l_m - m.l_m * k_r;
  const double l_m = k_r * m.l_m;
  const double r_r = k_r * k_r * m.r_r;
  double iron = 0;
  if (p.eddy_resistance > 0) iron += 1 / p.eddy_resistance;
  if (p.hysteresis_resistance > 0)
    iron += p.hysteresis_frequency / std::abs(omega_s) / p.hysteresis_resistance;
  const double slip = (omega_s - omega_r) / omega_s;
  const Complex behind = 1.0 / (1.0 / (j * omega_s * l_m) + iron + slip / r_r);
  SteadyState s;
  s.i_s = u_s / (m.r_s + j * omega_s * l_sigma + behind);
  const Complex e = s.i_s * behind;
  const Complex rotor = e * slip / r_r;  // into the rotor
  s.i_r = -k_r * rotor;
  const Complex psi = e / (j * omega_s);
  s.psi_s = psi + l_sigma * s.i_s;
  s.psi_r = psi / k_r;
  s.torque = 1.5 * m.pole_pairs * (std::conj(psi) * rotor).imag();
  s.loss = 1.5 * std::norm(e) * iron;
  return s;
}

Complex complex_of(SpaceVector<> x) {
  return {x.alpha, x.beta};
}

Plant::MachineState state_of(const SteadyState& s, double omega_m) {
  Plant::MachineState x = Plant::MachineState::Zero();
  x.head<5>() << s.psi_s.real(), s.psi_s.imag(), s.psi_r.real(), s.psi_r.imag(), omega_m;
  return x;
}

void expect_quantities(const Plant& plant, const Plant::MachineState& x, const SteadyState& expected,
                       double tolerance) {
  const PlantQuantities<> found = plant.quantities(x);
  const double current = std::abs(expected.i_s);
  EXPECT_LT(std::abs(complex_of(found.i_s) - expected.i_s), tolerance * current);
  EXPECT_LT(std::abs(complex_of(found.i_r) - expected.i_r), tolerance * current);
  EXPECT_NEAR(found.tau_e, expected.torque, tolerance * (1 + std::abs(expected.torque)));
  EXPECT_NEAR(found.iron_loss, expected.loss, tolerance * expected.loss);
  EXPECT_GT(expected.loss, 0);
}

// The fluxes of the circuit turn with the stator's frequency in the plant.
TEST(IronLoss, SteadyStateIsThatOfTheEquivalentCircuit) {
  const InductionMachineParameters<> m;
  for (const Parameters& p : cases) {
    const Plant plant = plant_with(p);
    for (const double omega_s : {fifty_hz, -fifty_hz, 2 * fifty_hz, -0.2 * fifty_hz}) {
      for (const double slip : {0.0, 0.03, -0.03, 0.4, 1.0}) {
        SCOPED_TRACE("R_e " + std::to_string(p.eddy_resistance) + ", R_h " +
                     std::to_string(p.hysteresis_resistance) + ", " + std::to_string(omega_s) +
                     " rad/s, slip " + std::to_string(slip));
        const double omega_m = omega_s * (1 - slip) / m.pole_pairs;
        const Complex u_s{0.5 * omega_s, 30.0};
        const SteadyState expected = circuit(m, p, u_s, omega_s, m.pole_pairs * omega_m);
        const Plant::MachineState x = state_of(expected, omega_m);
        expect_quantities(plant, x, expected, 1e-9);
        Plant::MachineState dx;
        plant.undriven_derivative(x, dx);
        const Complex turning{0, omega_s};
        const Complex d_s = u_s + Complex{dx[0], dx[1]}, d_r{dx[2], dx[3]};
        EXPECT_LT(std::abs(d_s - turning * expected.psi_s), 1e-9 * std::abs(u_s));
        EXPECT_LT(std::abs(d_r - turning * expected.psi_r), 1e-9 * std::abs(u_s));
      }
    }
  }
}

// And the plant settles there from another state.
TEST(IronLoss, SettlesAtThatSteadyState) {
  const InductionMachineParameters<> m;
  constexpr double h = 50e-6;
  constexpr int steps = 40'000;
  for (const double omega_s : {fifty_hz, -fifty_hz}) {
    SCOPED_TRACE(omega_s);
    const Plant plant = plant_with(both);
    const double omega_m = 0.97 * omega_s / m.pole_pairs;
    const auto u_s = [&](double n) { return std::polar(0.5 * fifty_hz, omega_s * h * n); };
    int step = 0;
    const auto slope = [&](double s, const Plant::MachineState& y, Plant::MachineState& dy) {
      plant.undriven_derivative(y, dy);
      const Complex u = u_s(step + s);
      dy[Plant::psi_s_alpha] += u.real();
      dy[Plant::psi_s_beta] += u.imag();
      dy[Plant::omega] = 0;
    };
    Plant::MachineState x = Plant::MachineState::Zero(), k;
    x[Plant::omega] = omega_m;
    for (; step < steps; ++step) {
      slope(0, x, k);
      x = runge_kutta_step(slope, x, k, h);
    }
    expect_quantities(plant, x, circuit(m, both, u_s(steps), omega_s, m.pole_pairs * omega_m), 1e-5);
  }
}

class RandomIron : public ::testing::Test {
 protected:
  static constexpr unsigned seed = 20261127;

  void SetUp() override { RecordProperty("seed", int(seed)); }
  double draw(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }
  SpaceVector<> vector(double most) { return {draw(-most, most), draw(-most, most)}; }
  DrivePlantParameters<> parameters() {
    DrivePlantParameters<> p;
    p.machine.l_ls = draw(0.0002, 0.01);
    p.machine.l_lr = draw(0.0002, 0.01);
    p.machine.l_m = draw(0.02, 0.3);
    p.machine.r_r = draw(0.05, 3.0);
    p.saturation.knee = draw(0, 1) < 0.5 ? 0.0 : draw(0.5, 1.5);
    p.iron_loss.hysteresis_frequency = draw(50, 1000);
    const double reactance = p.iron_loss.hysteresis_frequency * p.largest_magnetising_inductance();
    p.iron_loss.eddy_resistance = draw(0, 1) < 0.2 ? 0.0 : std::exp(draw(-2.0, 9.0));
    p.iron_loss.hysteresis_resistance = draw(0, 1) < 0.2 ? 0.0 : reactance * std::exp(draw(0.01, 5.0));
    return p;
  }
  static std::string trace(int n) { return "seed " + std::to_string(seed) + ", case " + std::to_string(n); }

 private:
  std::mt19937 random_{seed};
};

/// Currents and slope of the rotor flux obey the branch's law, and the rotor its own equation; the power that
/// goes in is work, loss and change of the field, to the digit, and no loss is below zero.
TEST_F(RandomIron, ObeysTheLawAndMakesNoPower) {
  int holds = 0;
  for (int n = 0; n < 3000; ++n) {
    SCOPED_TRACE(trace(n));
    const DrivePlantParameters<> p = parameters();
    const Plant plant = plant_of(p);
    const InductionMachineParameters<>& m = p.machine;
    Plant::MachineState x = Plant::MachineState::Zero(), dx;
    const SpaceVector<> psi_s = vector(1.3);
    const SpaceVector<> psi_r = draw(0, 1) < 0.5 ? vector(1.3) : m.l_m / m.l_s() * psi_s + vector(0.01);
    x.head<4>() << psi_s.alpha, psi_s.beta, psi_r.alpha, psi_r.beta;
    x[Plant::omega] = draw(0, 1) < 0.5 ? draw(-0.5, 0.5) : draw(-400, 400);
    plant.undriven_derivative(x, dx);
    const PlantQuantities<> q = plant.quantities(x);
    const SpaceVector<> dpsi_r{dx[Plant::psi_r_alpha], dx[Plant::psi_r_beta]};
    const double omega_e = m.pole_pairs * x[Plant::omega];
    const double scale = m.r_r * magnitude(plant.machine().rotor_current(psi_s, psi_r)) +
                         std::abs(omega_e) * magnitude(psi_r) + 1e-3;
    EXPECT_LT(magnitude(dpsi_r + m.r_r * q.i_r - omega_e * rotate_90(psi_r)), 1e-12 * scale);
    // Of the stator's turns.
    const SpaceVector<> i_fe = (1 / m.k_r()) * (q.i_r - plant.machine().rotor_current(psi_s, psi_r));
    const double g_eddy = p.iron_loss.eddy_resistance > 0 ? 1 / p.iron_loss.eddy_resistance : 0;
    const double c = p.iron_loss.hysteresis();
    const SpaceVector<> rest = i_fe - (g_eddy * m.k_r()) * dpsi_r;
    if (magnitude(dpsi_r) == 0) {
      ++holds;
      EXPECT_LE(magnitude(rest), c * m.k_r() * magnitude(psi_r) * (1 + 1e-12));
    } else {
      const SpaceVector<> hysteresis = (c * m.k_r() * magnitude(psi_r)) * direction(dpsi_r);
      EXPECT_LT(magnitude(rest - hysteresis), 1e-9 * scale / m.r_r);
    }
    EXPECT_NEAR(q.iron_loss, 1.5 * m.k_r() * dot(i_fe, dpsi_r), 1e-9 * (1 + q.iron_loss));
    EXPECT_GE(q.iron_loss, 0);
    // dW/dt: the currents without the iron's are the gradient of the field's energy.
    const SpaceVector<> dpsi_s{dx[Plant::psi_s_alpha], dx[Plant::psi_s_beta]};
    const double rise = 1.5 * (dot(q.i_s, dpsi_s) + dot(plant.machine().rotor_current(psi_s, psi_r), dpsi_r));
    const double copper = 1.5 * m.r_s * dot(q.i_s, q.i_s) + 1.5 * m.r_r * dot(q.i_r, q.i_r);
    const double work = q.tau_e * x[Plant::omega];
    EXPECT_NEAR(rise + copper + work + q.iron_loss, 0,
                1e-10 * (1 + copper + std::abs(work) + std::abs(rise)));
  }
  EXPECT_GT(holds, 50) << "cases in which hysteresis holds the flux";
}

TEST_F(RandomIron, JacobianIsTheDerivativeOfTheRightHandSide) {
  for (int n = 0; n < 400; ++n) {
    SCOPED_TRACE(trace(n));
    Plant plant = plant_of(parameters());
    Plant::State x = Plant::State::Zero();
    for (int i = 0; i < 4; ++i) x[i] = draw(-1.2, 1.2);
    x[Plant::omega] = draw(-150, 150);
    PlantInputs<> inputs = supply();
    inputs.state = switch_states[std::size_t(n) % 8];
    plant.set_inputs(inputs);
    Plant::Jacobian analytic;
    plant.jacobian(x, analytic);
    for (int c = 0; c < Plant::machine_size; ++c) {
      const double h = 1e-6;
      Plant::State ahead, behind;
      plant.derivative(x + h * Plant::State::Unit(c), ahead);
      plant.derivative(x - h * Plant::State::Unit(c), behind);
      const auto numeric = ((ahead - behind) / (2 * h)).head<Plant::machine_size>();
      EXPECT_LT((numeric - analytic.col(c).head<Plant::machine_size>()).cwiseAbs().maxCoeff(),
                1e-5 * (1 + numeric.cwiseAbs().maxCoeff()));
    }
  }
}

TEST(IronLoss, JacobianIsFiniteWithoutFlux) {
  const Plant plant = plant_with(both);
  Plant::Jacobian analytic;
  plant.jacobian(Plant::State::Zero(), analytic);
  EXPECT_TRUE(analytic.allFinite());
}

TEST(IronLoss, WithoutItTheMachineIsTheLinearOne) {
  Plant linear{DrivePlantParameters<>{}, Meter{}};
  Plant off = plant_with({0.0, 0.0, 100.0});
  Plant far = plant_with({1e9, 1e9, fifty_hz});
  EXPECT_TRUE(off.machine().is_linear());
  EXPECT_FALSE(far.machine().is_linear());
  FixedStepIntegrator<Plant> integrator;
  for (Plant* plant : {&linear, &off, &far}) {
    ASSERT_TRUE(run(*plant, integrator, switching_sequence(1000, 5), supply()));
    ASSERT_TRUE(run(*plant, integrator, std::vector<SwitchState>(40, gates_off), supply()));
  }
  EXPECT_EQ(linear.state(), off.state()) << "to the bit";
  EXPECT_EQ(linear.state()[Plant::appended + int(Meter::iron)], 0);
  EXPECT_LT((linear.state() - far.state()).norm(), 1e-4);
}

/// The meter without its last energy.
struct FourEnergies {
  static constexpr int size = 4;
  static constexpr bool is_integral = true;
  void derivative(const PlantQuantities<>& plant, std::span<const double, 4>,
                  std::span<double, 4> power) const noexcept {
    std::array<double, 5> all{};
    meter.derivative(plant, std::array<double, 5>{}, all);
    std::copy_n(all.begin(), 4, power.begin());
  }
  Meter meter{};
};

// A machine without iron loss moves in the steps that it has without an energy of the iron.
TEST(IronLoss, ItsEnergyHasNoSayInTheSteps) {
  using Four = DrivePlant<double, FourEnergies>;
  const auto compare = [](PlantIntegrator<Plant>& all, PlantIntegrator<Four>& four) {
    Plant plant = plant_with({});
    Four other{DrivePlantParameters<>{}, FourEnergies{}};
    for (const bool off : {false, true}) {
      const std::vector<SwitchState> sequence =
          off ? std::vector<SwitchState>(100, gates_off) : switching_sequence(1000, 5);
      ASSERT_TRUE(run(plant, all, sequence, supply()));
      ASSERT_TRUE(run(other, four, sequence, supply()));
    }
    EXPECT_EQ(plant.state().head<10>().eval(), other.state()) << "to the bit";
  };
  for (const AtSwitching way : {AtSwitching::stop, AtSwitching::go_on}) {
    SCOPED_TRACE(int(way));
    CvodeParameters parameters;
    parameters.at_switching = way;
    CvodeIntegrator<Plant> cvode{parameters};
    CvodeIntegrator<Four> cvode_of_four{parameters};
    compare(cvode, cvode_of_four);
    ErkIntegrator<Plant> erk{parameters};
    ErkIntegrator<Four> erk_of_four{parameters};
    compare(erk, erk_of_four);
  }
}

/// With an open stator, at standstill.
TEST(IronLoss, AFluxDecaysWithoutACurrent) {
  for (const Parameters& p : cases) {
    SCOPED_TRACE(p.hysteresis_resistance);
    Plant plant = plant_with(p);
    const SpaceVector<> psi_r = polar(1.2, 0.7);
    plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
    PlantInputs<> inputs = supply();
    inputs.imposed_speed = true;
    FixedStepIntegrator<Plant> integrator;
    const double energy = plant.magnetic_energy();
    double before = energy;
    for (int n = 0; n < 40; ++n) {
      ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(1000, gates_off), inputs));
      EXPECT_LE(plant.magnetic_energy(), before) << "no energy from nothing";
      before = plant.magnetic_energy();
    }
    EXPECT_LT(magnitude(plant.i_s()), 1e-6);
    EXPECT_LT(before, 0.1 * energy);
    const auto lost = [&](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
    EXPECT_GT(lost(Meter::iron), 0);
    EXPECT_NEAR(energy - before, lost(Meter::iron) + lost(Meter::rotor_copper), 1e-7 * energy);
  }
}

/// A field that stands still brakes the rotor, either way.
TEST(IronLoss, BrakesAShaftInAFieldThatStandsStill) {
  Plant plant = plant_with(both);
  const double current = 10.0;
  const InductionMachineParameters<> m;
  plant.set_fluxes({m.l_s() * current, 0}, {m.l_m * current, 0});
  plant.set_speed(50);
  EXPECT_LT(plant.tau_e(), 0);
  plant.set_speed(-50);
  EXPECT_GT(plant.tau_e(), 0);
}

double unaccounted(const Plant& plant) {
  const auto energy = [&](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
  const double in = energy(Meter::dc_link);
  const double lost = energy(Meter::stator_copper) + energy(Meter::rotor_copper) + energy(Meter::iron);
  EXPECT_GT(energy(Meter::iron), 1e-3 * lost);
  return std::abs(in - lost - energy(Meter::mechanical) - plant.magnetic_energy()) / (std::abs(in) + lost);
}

void expect_closed_energy(PlantIntegrator<Plant>& integrator, const DrivePlantParameters<>& p,
                          std::size_t periods, double limit) {
  Plant plant = plant_of(p);
  integrator.reset();
  ASSERT_TRUE(run(plant, integrator, switching_sequence(periods, 11), supply()));
  EXPECT_LT(unaccounted(plant), limit);
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(200, gates_off), supply()));
  std::vector<SwitchState> open_phase = switching_sequence(2000, 12);
  for (SwitchState& state : open_phase) state = {state.a(), LegState::off, state.c()};
  ASSERT_TRUE(run(plant, integrator, open_phase, supply()));
  EXPECT_LT(unaccounted(plant), limit);
}

TEST(IronLoss, EnergyClosesOverSecondsWithCvode) {
  CvodeIntegrator<Plant> integrator;
  for (const Parameters& p : cases) expect_closed_energy(integrator, parameters_with(p), 20'000, 1e-5);
  expect_closed_energy(integrator, parameters_with(both, {1.1, 7, 1.0}), 20'000, 1e-5);
}

TEST(IronLoss, EnergyClosesWithNewtonsIteration) {
  CvodeParameters parameters;
  parameters.method = CvodeMethod::bdf_newton;
  CvodeIntegrator<Plant> integrator{parameters};
  for (const Parameters& p : cases) expect_closed_energy(integrator, parameters_with(p), 8'000, 1e-5);
}

TEST(IronLoss, EnergyClosesWithTheFixedStepAndErk) {
  FixedStepIntegrator<Plant> fixed;
  ErkIntegrator<Plant> erk;
  for (const Parameters& p : cases) {
    expect_closed_energy(fixed, parameters_with(p, {1.1, 7, 1.0}), 20'000, 1e-5);
    expect_closed_energy(erk, parameters_with(p, {1.1, 7, 1.0}), 8'000, 1e-5);
  }
}

/// Saturation, drops of the inverter, and a dead time at each change.
TEST(IronLoss, EnergyClosesWithEverythingOn) {
  DrivePlantParameters<> p = parameters_with(both, {1.1, 7, 1.0});
  p.drops = {1.2, 0.02};
  Plant plant = plant_of(p);
  CvodeIntegrator<Plant> integrator;
  PlantInputs<> inputs = supply();
  const std::vector<SwitchState> sequence = switching_sequence(2000, 11);
  SwitchState last = gates_off;
  for (std::size_t n = 0; n < 20'000; ++n) {
    const SwitchState next = sequence[n % sequence.size()];
    const auto dead = [](LegState a, LegState b) { return a == b ? a : LegState::off; };
    inputs.state = {dead(last.a(), next.a()), dead(last.b(), next.b()), dead(last.c(), next.c())};
    plant.set_inputs(inputs);
    ASSERT_TRUE(integrator.advance(plant, 1'500));
    inputs.state = next;
    plant.set_inputs(inputs);
    ASSERT_TRUE(integrator.advance(plant, 23'500));
    last = next;
  }
  EXPECT_LT(unaccounted(plant), 1e-5);
  EXPECT_GT(magnitude(plant.psi_s()), 0.1);
}

TEST(IronLoss, FloatAgreesWithDouble) {
  const InductionMachine<double> d{InductionMachineParameters<double>{}, {}, both};
  const InductionMachine<float> f{InductionMachineParameters<float>{}, {}, {600.0F, 900.0F, float(fifty_hz)}};
  const auto single = f.iron_branch({1.0F, 2.0F}, {0.8F, 0.6F}, 100.0F);
  const auto expected = d.iron_branch({1.0, 2.0}, {0.8, 0.6}, 100.0);
  EXPECT_NEAR(double(single.power), expected.power, 1e-4 * expected.power);
  EXPECT_NEAR(double(single.torque), expected.torque, 1e-4 * std::abs(expected.torque));
}

}  // namespace
}  // namespace sextant
