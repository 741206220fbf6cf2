// A motor cable that opens, against the equations of a machine with two connected phases.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <random>
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
using Inv = Inverter<double>;

constexpr double u_dc = 530.0;

struct Named {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
};

std::vector<Named> all_integrators() {
  CvodeParameters cvode{};
  cvode.relative_tolerance = 1e-10;
  cvode.flux_tolerance = 1e-12;
  ErrorControl erk{};
  erk.relative_tolerance = 1e-10;
  erk.flux_tolerance = 1e-12;
  std::vector<Named> list;
  list.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>(cvode)});
  list.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>()});
  list.push_back({"exact", std::make_unique<ExactIntegrator<Plant>>()});
  list.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>(erk)});
  return list;
}

/// At an imposed speed with flux along psi and no current.
Plant spinning(double omega_m, SpaceVector<double> psi_r) {
  const DrivePlantParameters<double> p{};
  Plant plant{p, Meter{}};
  plant.set_inputs({switch_states[0], u_dc, 0.0, true, 0.0});
  plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
  plant.set_speed(omega_m);
  return plant;
}

void apply(Plant& plant, PlantIntegrator<Plant>& integrator, SwitchState state) {
  PlantInputs<double> inputs = plant.inputs();
  inputs.state = state;
  plant.set_inputs(inputs);
  ASSERT_TRUE(integrator.advance(plant, switching_period_ns));
}

double current_of(const Plant& plant, std::size_t phase) {
  return phases_of(plant.i_s())[phase];
}

constexpr std::size_t turn = 1'920;  // periods: 20.8 Hz

/// A turning voltage: the active vector of each sixth, and a zero vector in half of the periods.
SwitchState turning(std::size_t n) {
  return n % 2 == 0 ? switch_states[1 + 6 * n / turn % 6] : switch_states[0];
}

TEST(OpenPhase, TheCurrentFlowsToItsZeroAndStaysThere) {
  for (const Named& by : all_integrators()) {
    for (std::size_t phase = 0; phase < 3; ++phase) {
      SCOPED_TRACE(by.name + ", phase " + std::to_string(phase));
      Plant whole = spinning(60.0, {0.5, 0.0});
      by.integrator->reset();
      FixedStepIntegrator<Plant> reference;
      Plant plant = whole;
      std::size_t n = 0;
      for (; n < 400; ++n) {
        apply(whole, reference, turning(n));
        apply(plant, *by.integrator, turning(n));
      }
      ASSERT_GT(std::abs(current_of(plant, phase)), 2.0);
      plant.open_phase(int(phase));
      const double sign = current_of(plant, phase) > 0 ? 1.0 : -1.0;
      std::size_t until_zero = 0;
      while (current_of(plant, phase) * sign > 1e-6) {
        EXPECT_NEAR(current_of(plant, phase), current_of(whole, phase), 1e-3) << "as with a whole cable";
        apply(whole, reference, turning(n));
        apply(plant, *by.integrator, turning(n++));
        ASSERT_LT(++until_zero, 8'000U);
      }
      EXPECT_GT(until_zero, 4U);
      EXPECT_LT(current_of(whole, phase) * sign, 1e-3) << "the whole machine's current has crossed zero too";
      double largest = 0;
      for (std::size_t k = 0; k < 4'000; ++k, ++n) {
        apply(plant, *by.integrator, turning(n));
        EXPECT_NEAR(current_of(plant, phase), 0.0, 1e-7);
        EXPECT_NEAR(current_of(plant, (phase + 1) % 3), -current_of(plant, (phase + 2) % 3), 1e-7);
        largest = std::max(largest, std::abs(current_of(plant, (phase + 1) % 3)));
      }
      EXPECT_GT(largest, 2.0);
    }
  }
}

// Within a segment too, where nothing switches at the zero: 100 µs or so into the millisecond of V4.
TEST(OpenPhase, TheArcEndsAtTheZeroItself) {
  for (const Named& by : all_integrators()) {
    SCOPED_TRACE(by.name);
    Plant plant = spinning(0.0, {});
    for (int n = 0; n < 4; ++n) apply(plant, *by.integrator, switch_states[1]);
    const double i = current_of(plant, 0);
    ASSERT_GT(i, 5.0);
    plant.open_phase(0);
    PlantInputs<double> inputs = plant.inputs();
    inputs.state = switch_states[4];
    plant.set_inputs(inputs);
    ASSERT_TRUE(by.integrator->advance(plant, 1'000'000));
    EXPECT_NEAR(current_of(plant, 0), 0.0, 1e-9);
    // What phases b and c carried against a is gone with it; V4 has no voltage between them.
    EXPECT_NEAR(current_of(plant, 1), 0.0, 1e-3);
    EXPECT_EQ(plant.inverter().ties()[0], LegTie::floating);
    EXPECT_NEAR(magnitude(plant.psi_s()), 0.0, 0.01);
  }
}

// With phase a open i_alpha is zero. Beta: σL_s di/dt = (v_b − v_c)/√3 − R_s i − k_r dψ_r,beta/dt, and the
// rotor is dψ_r/dt = −ψ_r/τ_r + L_m/τ_r j i + j p ω ψ_r. Integrated here by itself, in steps of 1 µs.
TEST(OpenPhase, IsAMachineWithTwoPhases) {
  const InductionMachineParameters<double> m{};
  const double omega = 40.0;
  struct State {
    double i, a, b;
  };
  const auto slope = [&m, omega](State x, double u) {
    const double w = double(m.pole_pairs) * omega;
    const double da = -x.a / m.tau_r() - w * x.b;
    const double db = (m.l_m * x.i - x.b) / m.tau_r() + w * x.a;
    return State{(u - m.r_s * x.i - m.k_r() * db) / m.sigma_l_s(), da, db};
  };
  const auto along = [](State x, double h, State k) {
    return State{x.i + h * k.i, x.a + h * k.a, x.b + h * k.b};
  };
  for (const Named& by : all_integrators()) {
    SCOPED_TRACE(by.name);
    Plant plant = spinning(omega, {0.6, 0.2});
    plant.open_phase(0);
    State x{0.0, 0.6, 0.2};
    for (std::size_t n = 0; n < 2'000; ++n) {
      const SwitchState state = turning(n);
      const double b = state.b() == LegState::high ? u_dc : 0.0;
      const double c = state.c() == LegState::high ? u_dc : 0.0;
      const double u = (b - c) / std::numbers::sqrt3;
      apply(plant, *by.integrator, state);
      constexpr double h = 1e-6;
      for (int k = 0; k < 25; ++k) {
        const State k1 = slope(x, u);
        const State k2 = slope(along(x, h / 2, k1), u);
        const State k3 = slope(along(x, h / 2, k2), u);
        const State k4 = slope(along(x, h, k3), u);
        x = along(along(along(along(x, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
      }
      ASSERT_NEAR(plant.i_s().beta, x.i, 1e-4) << "period " << n;
      ASSERT_NEAR(plant.i_s().alpha, 0.0, 1e-9);
      ASSERT_NEAR(plant.psi_r().alpha, x.a, 1e-6);
      ASSERT_NEAR(plant.psi_r().beta, x.b, 1e-6);
      // 3/2 p k_r ψ_r × i_s
      ASSERT_NEAR(plant.tau_e(), 1.5 * m.pole_pairs * m.k_r() * x.a * x.i, 1e-3);
    }
  }
}

// At rest the flux across the open phase's axis decays with the rotor time constant, whatever is switched.
TEST(OpenPhase, AtRestTheTorqueEndsWithTheRotorsFlux) {
  Plant plant = spinning(0.0, {0.8, 0.0});
  plant.open_phase(0);
  FixedStepIntegrator<Plant> integrator;
  for (std::size_t n = 1; n <= 20'000; ++n) {
    apply(plant, integrator, turning(n));
    const InductionMachineParameters<double>& m = plant.machine().parameters();
    const double psi_r = 0.8 * std::exp(-double(n) * 25e-6 / m.tau_r());
    ASSERT_NEAR(plant.psi_r().alpha, psi_r, 1e-8);
    ASSERT_NEAR(plant.tau_e(), 1.5 * m.pole_pairs * m.k_r() * psi_r * plant.i_s().beta, 1e-6);
  }
  EXPECT_GT(std::abs(plant.i_s().beta), 10.0);
}

// The field of one current pulsates instead of turning: so does the torque, at twice the frequency, which
// the six sixths of a turn cannot make.
TEST(OpenPhase, TheTorquePulsatesAtTwiceTheFrequency) {
  const auto second_harmonic = [](bool is_open) {
    Plant plant = spinning(50.0, {0.5, 0.0});
    FixedStepIntegrator<Plant> integrator;
    if (is_open) plant.open_phase(1);
    double cosine = 0, sine = 0;
    constexpr std::size_t settle = 60 * turn, window = 4 * turn;
    for (std::size_t n = 0; n < settle + window; ++n) {
      apply(plant, integrator, turning(n));
      if (n < settle) continue;
      const double angle = 4 * std::numbers::pi * double(n + 1) / double(turn);
      cosine += plant.tau_e() * std::cos(angle) * 2 / double(window);
      sine += plant.tau_e() * std::sin(angle) * 2 / double(window);
    }
    return std::hypot(cosine, sine);
  };
  EXPECT_LT(second_harmonic(false), 0.1);
  EXPECT_GT(second_harmonic(true), 2.0);
}

// An open cable beside driven legs, legs off, diodes and a cable that is whole again.
TEST(OpenPhase, KeepsTheBalanceOfEnergyWithEveryIntegrator) {
  for (const Named& by : all_integrators()) {
    SCOPED_TRACE(by.name);
    Plant plant = spinning(60.0, {});
    PlantInputs<double> inputs = supply();
    const auto go = [&](const std::vector<SwitchState>& sequence) {
      ASSERT_TRUE(run(plant, *by.integrator, sequence, inputs));
    };
    go(switching_sequence(2'000, 11));
    for (const int phase : {0, 2}) {
      plant.open_phase(phase);
      go(switching_sequence(6'000, 12));
      EXPECT_NEAR(current_of(plant, std::size_t(phase)), 0.0, 1e-6);
      go(std::vector<SwitchState>(100, gates_off));
      std::vector<SwitchState> leg_off = switching_sequence(500, 13);
      for (SwitchState& state : leg_off) state = {state.a(), LegState::off, state.c()};
      go(leg_off);
      go(switching_sequence(500, 14));
      plant.open_phase(Inv::no_phase);
      go(switching_sequence(500, 15));
      EXPECT_GT(std::abs(current_of(plant, std::size_t(phase))), 1e-3);
    }
    const auto energy = [&plant](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
    const double copper = energy(Meter::stator_copper) + energy(Meter::rotor_copper);
    const double in = energy(Meter::dc_link);
    EXPECT_GT(copper, 5.0);
    EXPECT_NEAR(in, copper + energy(Meter::mechanical) + plant.magnetic_energy(),
                1e-5 * (std::abs(in) + copper));
  }
}

// Legs on and off, the speed and the cable at random: every integrator comes through, on the same way.
TEST(OpenPhase, EveryIntegratorComesThroughAnySequence) {
  constexpr unsigned seed = 23;
  SCOPED_TRACE(seed);
  std::vector<Plant> ends;
  for (const Named& by : all_integrators()) {
    SCOPED_TRACE(by.name);
    std::mt19937 random{seed};
    Plant plant = spinning(0.0, {});
    for (std::size_t n = 0; n < 8'000; ++n) {
      if (random() % 100U == 0) plant.open_phase(int(random() % 4U) - 1);
      if (random() % 500U == 0) plant.set_speed(double(random() % 400U) - 200.0);
      const bool leg_off = random() % 10U == 0;
      SwitchState state = turning(n);
      if (leg_off) state = {LegState(random() % 3U), LegState(random() % 3U), LegState(random() % 3U)};
      apply(plant, *by.integrator, state);
      ASSERT_TRUE(plant.is_reachable());
    }
    ends.push_back(plant);
  }
  EXPECT_GT(magnitude(ends[0].psi_s()), 0.05);
  for (const Plant& end : ends) EXPECT_LT(magnitude(end.psi_s() - ends[0].psi_s()), 1e-5);
}

TEST(OpenPhase, ACurrentOfZeroIsInterruptedAtOnce) {
  Plant plant = spinning(30.0, {0.5, 0.0});
  plant.open_phase(1);
  EXPECT_EQ(plant.inverter().ties()[1], LegTie::floating);
  plant.open_phase(Inv::no_phase);
  EXPECT_EQ(plant.inverter().ties()[1], LegTie::low);
  EXPECT_FALSE(plant.has_events());
}

TEST(OpenPhase, ANewRevisionComesWithAChangeAlone) {
  Plant plant = spinning(30.0, {0.5, 0.0});
  const std::uint64_t whole = plant.revision();
  plant.open_phase(Inv::no_phase);
  EXPECT_EQ(plant.revision(), whole);
  plant.open_phase(1);
  const std::uint64_t open = plant.revision();
  EXPECT_NE(open, whole);
  plant.open_phase(1);
  EXPECT_EQ(plant.revision(), open);
}

// In every topology: no current in the open phase, power balances, no diode is left out, no event is pending.
TEST(OpenPhase, EveryTopologyIsConsistent) {
  constexpr unsigned seed = 17;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> amps{-20, 20};
  std::uniform_real_distribution<double> volts{-400, 400};
  for (int n = 0; n < 20'000; ++n) {
    SCOPED_TRACE(n);
    const auto leg = [&random] { return LegState(random() % 3U); };
    const SwitchState state{leg(), leg(), leg()};
    const std::size_t x = random() % 3U;
    const std::size_t y = (x + 1) % 3;
    const std::size_t z = (x + 2) % 3;
    const double amplitude = random() % 3U == 0 ? 0.0 : amps(random);
    std::array<double, 3> phases{};
    phases[y] = amplitude;
    phases[z] = -amplitude;
    SpaceVector<double> i = clarke(ThreePhase<double>{phases[0], phases[1], phases[2]});
    const SpaceVector<double> e{volts(random), volts(random)};
    Inv inverter;
    inverter.open_phase(int(x), i);
    inverter.set(state, u_dc, i, e);
    i = inverter.admissible_current(i);
    EXPECT_NEAR(phases_of(i)[x], 0.0, 1e-9);
    EXPECT_EQ(inverter.ties()[x], LegTie::floating);
    const SpaceVector<double> u = inverter.voltage_map()(e);
    EXPECT_NEAR(phases_of(u)[x] - phases_of(e)[x], 0.0, 1e-9) << "an open phase has its EMF across it";
    EXPECT_NEAR(1.5 * dot(u, i), u_dc * inverter.dc_link_current(i), 1e-9);
    const std::array<double, 3> g = inverter.events(i, e);
    EXPECT_GE(*std::min_element(g.begin(), g.end()), 0.0);
    if (floating_legs(inverter.ties()) == 3) continue;
    for (const std::size_t k : {y, z}) {
      EXPECT_GE(inverter.leg_potentials(e)[k], -2 * Inv::voltage_tolerance);
      EXPECT_LE(inverter.leg_potentials(e)[k], u_dc + 2 * Inv::voltage_tolerance);
    }
  }
}

// Both diodes of the two connected phases, and those of the open one not, carry what the EMF rectifies.
TEST(OpenPhase, TwoPhasesRectifyAboveTheLink) {
  const SpaceVector<double> e = clarke(ThreePhase<double>{400, -100, -300});
  Inv inverter;
  inverter.open_phase(0, {});
  inverter.set(gates_off, u_dc, {}, e);
  EXPECT_EQ(floating_legs(inverter.ties()), 3) << "200 V between the connected phases are below the link";
  const SpaceVector<double> more = clarke(ThreePhase<double>{0, 270, -270});
  EXPECT_LT(inverter.events({}, more)[0], 0.0);
  inverter.on_event(0, {}, more);
  EXPECT_EQ(inverter.ties(), (LegTies{LegTie::floating, LegTie::high, LegTie::low}));
}

TEST(OpenPhase, TheLargestLinkVoltageSoFarBoundsTheFlux) {
  Plant plant = spinning(0.0, {});
  PlantInputs<double> inputs = plant.inputs();
  const InductionMachineParameters<double> m{};
  const double largest = 2.0 / 3.0 * u_dc * m.l_s() / m.r_s;
  inputs.u_dc = 1.0;
  plant.set_inputs(inputs);
  plant.set_fluxes({0.99 * largest, 0.0}, {});
  EXPECT_TRUE(plant.is_reachable());
  plant.set_fluxes({1.01 * largest, 0.0}, {});
  EXPECT_FALSE(plant.is_reachable());
}

}  // namespace
}  // namespace sextant
