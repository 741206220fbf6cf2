// The induction machine with a main flux that saturates, against its law, the Γ circuit and energy.
#include <cmath>
#include <memory>
#include <random>
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

namespace sextant {
namespace {

using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;
using Parameters = SaturationParameters<>;

Plant plant_with(const Parameters& saturation) {
  DrivePlantParameters<> p;
  p.saturation = saturation;
  return Plant{p, Meter{}};
}

/// The law as it is published. [A]
double magnetising_current(const Parameters& p, double l_s, double psi) {
  const double l_su = l_s * (1 + std::pow(p.machine_flux / p.knee, p.exponent));
  return psi * (1 + std::pow(psi / p.knee, p.exponent)) / l_su;
}

/// The knee is at the paper's flux of 1.1 Wb, or far below it.
const std::vector<Parameters> cases{
    {1.1, 7, 0.0}, {1.1, 7, 1.1}, {1.3, 2, 1.0}, {1.1, 20, 1.15}, {0.7, 5, 0.0}};

TEST(Saturation, ParametersAreChecked) {
  const auto problem = [](const Parameters& p) {
    return std::string{p.validate() == nullptr ? "" : p.validate()};
  };
  for (const Parameters& p : cases) EXPECT_EQ(problem(p), "");
  EXPECT_EQ(problem({}), "");
  EXPECT_THAT(problem({-1, 7, 0}), ::testing::HasSubstr("knee"));
  EXPECT_THAT(problem({NAN, 7, 0}), ::testing::HasSubstr("knee"));
  EXPECT_THAT(problem({1, 1, 0}), ::testing::HasSubstr("exponent"));
  EXPECT_THAT(problem({1, 21, 0}), ::testing::HasSubstr("exponent"));
  EXPECT_THAT(problem({1, 7, -1}), ::testing::HasSubstr("not below zero"));
  EXPECT_THAT(problem({1, 7, INFINITY}), ::testing::HasSubstr("finite"));
  EXPECT_EQ(problem({1, 2, 2.99}), "") << "nine times the inductance";
  EXPECT_THAT(problem({1, 2, 3.01}), ::testing::HasSubstr("too far above the knee"));
  EXPECT_EQ(problem({0, 7, 3}), "") << "without a knee it does not count";
}

TEST(Saturation, ThePlantChecksIt) {
  DrivePlantParameters<> p;
  p.saturation.knee = -1;
  EXPECT_THAT(p.validate(), ::testing::HasSubstr("knee"));
}

TEST(Saturation, NoLoadCurrentIsOnTheCurve) {
  const InductionMachineParameters<> m;
  for (const Parameters& p : cases) {
    const InductionMachine<> machine{m, p};
    for (const double psi : {0.0, 0.01, 0.3, 0.9, 1.1, 1.6, 3.0}) {
      SCOPED_TRACE(psi);
      const SpaceVector<> psi_s = polar(psi, 2.0);
      const SpaceVector<> psi_r = (m.l_m / m.l_s()) * psi_s;  // no current in the rotor
      EXPECT_LT(magnitude(machine.rotor_current(psi_s, psi_r)), 1e-12 * (1 + psi / m.sigma_l_s()));
      const SpaceVector<> expected = polar(magnetising_current(p, m.l_s(), psi), 2.0);
      EXPECT_LT(magnitude(machine.stator_current(psi_s, psi_r) - expected),
                1e-10 * (1 + magnitude(expected)));
    }
  }
}

TEST(Saturation, TheMachinesInductancesHoldAtItsFlux) {
  const InductionMachineParameters<> m;
  const InductionMachine<> machine{m, {1.2, 7, 1.0}};
  const InductionMachine<> linear{m};
  const SpaceVector<> at{0.6, -0.8};
  const SpaceVector<> psi_r{0.5, 0.4};
  EXPECT_LT(magnitude(machine.stator_current(at, psi_r) - linear.stator_current(at, psi_r)), 1e-12);
  EXPECT_GT(machine.largest_inductance(), 1.2 * m.l_s());
  EXPECT_LT(dot(at, machine.stator_current(0.9 * at, psi_r)),
            dot(at, linear.stator_current(0.9 * at, psi_r)));
  EXPECT_GT(dot(at, machine.stator_current(1.1 * at, psi_r)),
            dot(at, linear.stator_current(1.1 * at, psi_r)));
}

// At constant fluxes the curve is known by its chord and its slope.
TEST(Saturation, TheChordIsTheMachineOfTheSameFluxes) {
  const InductionMachineParameters<> m;
  for (const Parameters& p : cases) {
    const SaturationCurve<> curve{p, m.l_s()};
    for (const double psi : {0.0, 0.2, 0.8, 1.1, 1.4}) {
      SCOPED_TRACE(testing::Message() << p.knee << ' ' << p.exponent << ' ' << psi);
      const SpaceVector<> psi_s = polar(psi, -0.7);
      const SpaceVector<> psi_r{0.3, -0.9};
      const InductionMachine<> saturated{m, p};
      const InductionMachine<> chord{curve.machine_at(m, psi_s)};
      const SpaceVector<> i_s = saturated.stator_current(psi_s, psi_r);
      EXPECT_LT(magnitude(chord.stator_current(psi_s, psi_r) - i_s), 1e-9 * (1 + magnitude(i_s)));
      const SpaceVector<> i_r = saturated.rotor_current(psi_s, psi_r);
      EXPECT_LT(magnitude(chord.rotor_current(psi_s, psi_r) - i_r), 1e-9 * (1 + magnitude(i_r)));
      const double h = 1e-5;
      const auto log_current = [&](double x) { return std::log(magnetising_current(p, m.l_s(), x)); };
      const double slope = psi > 0 ? psi * (log_current(psi + h) - log_current(psi - h)) / (2 * h) - 1 : 0;
      EXPECT_NEAR(curve.steepness(psi_s), slope, 1e-5);
    }
  }
}

TEST(Saturation, WithoutItTheChordIsTheMachine) {
  const InductionMachineParameters<> m;
  const SaturationCurve<> none{Parameters{}, m.l_s()};
  const InductionMachineParameters<> chord = none.machine_at(m, {0.5, 0.1});
  EXPECT_EQ(chord.l_m, m.l_m);
  EXPECT_EQ(chord.l_ls, m.l_ls);
  EXPECT_EQ(chord.l_lr, m.l_lr);
  EXPECT_EQ(none.steepness({0.5, 0.1}), 0);
}

class RandomMachines : public ::testing::Test {
 protected:
  static constexpr unsigned seed = 20261126;

  void SetUp() override { RecordProperty("seed", int(seed)); }
  double draw(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }
  SpaceVector<> vector(double most) { return {draw(-most, most), draw(-most, most)}; }
  InductionMachineParameters<> machine() {
    InductionMachineParameters<> m;
    m.l_ls = draw(0.0002, 0.01);
    m.l_lr = draw(0.0002, 0.01);
    m.l_m = draw(0.02, 0.3);
    return m;
  }
  Parameters saturation() {
    Parameters p{draw(0.5, 1.5), int(draw(2, 20.99)), 0.0};
    p.machine_flux = draw(0.0, 1.1) * p.knee;
    return p;
  }

 private:
  std::mt19937 random_{seed};
};

TEST_F(RandomMachines, AreTheGammaCircuit) {
  for (int n = 0; n < 1000; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const InductionMachineParameters<> m = machine();
    const Parameters p = saturation();
    const InductionMachine<> saturating{m, p};
    const SpaceVector<> psi_s = vector(1.2), psi_r = vector(1.2);
    const double gamma = m.l_s() / m.l_m;
    const double l_sigma = gamma * m.l_ls + gamma * gamma * m.l_lr;
    const double psi = magnitude(psi_s);
    const SpaceVector<> leakage = (1 / l_sigma) * (psi_s - gamma * psi_r);
    const SpaceVector<> i_s = (magnetising_current(p, m.l_s(), psi) / psi) * psi_s + leakage;
    EXPECT_LT(magnitude(saturating.stator_current(psi_s, psi_r) - i_s), 1e-9 * (1 + magnitude(i_s)));
    EXPECT_LT(magnitude(saturating.rotor_current(psi_s, psi_r) + gamma * leakage),
              1e-9 * (1 + magnitude(leakage)));
  }
}

TEST_F(RandomMachines, FluxFollowsFromCurrent) {
  for (int n = 0; n < 1000; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const InductionMachine<> saturating{machine(), saturation()};
    const SpaceVector<> psi_s = vector(4.0), psi_r = vector(1.5);
    const SpaceVector<> i_s = saturating.stator_current(psi_s, psi_r);
    EXPECT_LT(magnitude(saturating.stator_flux(i_s, psi_r) - psi_s), 1e-12 * (1 + magnitude(psi_s)));
    EXPECT_EQ(magnitude(saturating.stator_flux({}, {})), 0.0);
  }
}

// The field is passive: what the windings deliver is the change of a function of the fluxes.
TEST_F(RandomMachines, CurrentsAreTheGradientOfTheFieldsEnergy) {
  for (int n = 0; n < 300; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const InductionMachine<> saturating{machine(), saturation()};
    const SpaceVector<> psi_s = vector(1.3), psi_r = vector(1.3);
    const SpaceVector<> along_s = vector(1.0), along_r = vector(1.0);
    constexpr double h = 1e-5;
    const auto energy = [&](double x) {
      return saturating.magnetic_energy(psi_s + x * along_s, psi_r + x * along_r);
    };
    const double numeric = (energy(h) - energy(-h)) / (2 * h);
    const double power = 1.5 * (dot(saturating.stator_current(psi_s, psi_r), along_s) +
                                dot(saturating.rotor_current(psi_s, psi_r), along_r));
    EXPECT_NEAR(numeric, power, 1e-6 * (1 + std::abs(power) + std::abs(energy(0))));
    EXPECT_GT(energy(0), 0);
  }
}

TEST_F(RandomMachines, InverseInductanceIsTheSlopeOfTheCurrent) {
  for (int n = 0; n < 300; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const InductionMachine<> saturating{machine(), saturation()};
    const SpaceVector<> psi_s = vector(1.3);
    const SpaceVector<> unit = direction(psi_s);
    const auto slope = [&](SpaceVector<> step) {
      return 0.5e6 * (saturating.stator_current(psi_s + 1e-6 * step, {}) -
                      saturating.stator_current(psi_s - 1e-6 * step, {}));
    };
    const auto inverse = saturating.inverse_inductance(psi_s, {});
    const double scale = inverse.across + inverse.added_along;
    EXPECT_LT(magnitude(slope(unit) - scale * unit), 1e-6 * scale);
    EXPECT_LT(magnitude(slope(rotate_90(unit)) - inverse.across * rotate_90(unit)), 1e-6 * scale);
  }
}

TEST(Saturation, WithoutItTheMachineIsTheLinearOne) {
  Plant linear{DrivePlantParameters<>{}, Meter{}};
  Plant off = plant_with({0.0, 9, 1.0});
  Plant far = plant_with({1e6, 7, 0.0});
  EXPECT_TRUE(off.machine().is_linear());
  EXPECT_FALSE(far.machine().is_linear());
  FixedStepIntegrator<Plant> integrator;
  for (Plant* plant : {&linear, &off, &far}) {
    ASSERT_TRUE(run(*plant, integrator, switching_sequence(1000, 5), supply()));
    ASSERT_TRUE(run(*plant, integrator, std::vector<SwitchState>(40, gates_off), supply()));
  }
  EXPECT_EQ(linear.state(), off.state()) << "to the bit";
  EXPECT_LT((linear.state() - far.state()).norm(), 1e-9);
}

TEST(Saturation, JacobianIsTheDerivativeOfTheRightHandSide) {
  constexpr unsigned seed = 3;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> uniform{-1, 1};
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    Plant plant = plant_with(cases[std::size_t(n) % cases.size()]);
    Plant::State x = Plant::State::Zero();
    for (int i = 0; i < 4; ++i) x[i] = 1.2 * uniform(random);
    x[Plant::omega] = 150 * uniform(random);
    if (n == 0) x.setZero();
    PlantInputs<> inputs = supply();
    inputs.state = switch_states[std::size_t(n) % 8];
    plant.set_inputs(inputs);
    Plant::Jacobian analytic;
    plant.jacobian(x, analytic);
    for (int c = 0; c < Plant::machine_size; ++c) {
      const double h = 1e-5;
      Plant::State ahead, behind;
      plant.derivative(x + h * Plant::State::Unit(c), ahead);
      plant.derivative(x - h * Plant::State::Unit(c), behind);
      const auto numeric = ((ahead - behind) / (2 * h)).head<Plant::machine_size>();
      EXPECT_LT((numeric - analytic.col(c).head<Plant::machine_size>()).cwiseAbs().maxCoeff(),
                1e-6 * (1 + numeric.cwiseAbs().maxCoeff()));
    }
  }
}

// The transient inductance is smaller along the flux: a leg floats only if the voltage is found with that.
TEST(Saturation, CurrentOfAFloatingLegStaysZero) {
  for (const Parameters& p : cases) {
    SCOPED_TRACE(p.knee);
    Plant plant = plant_with(p);
    FixedStepIntegrator<Plant> integrator{FixedStepParameters{5'000}};
    PlantInputs<> inputs = supply();
    inputs.imposed_speed = true;
    const SpaceVector<> psi_r = polar(1.3 * p.knee, 0.7);
    plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
    plant.set_speed(10);
    ASSERT_GT(magnitude(plant.psi_s()), 0.9 * p.knee);
    int floating = 0;
    double most = 0;
    for (const SwitchState state : switching_sequence(3000, 12)) {
      inputs.state = {state.a(), LegState::off, state.c()};
      plant.set_inputs(inputs);
      const bool floats = plant.inverter().ties()[1] == LegTie::floating;
      const double before = plant.i_abc().b;
      ASSERT_TRUE(integrator.advance(plant, 5'000));
      if (!floats || plant.inverter().ties()[1] != LegTie::floating) continue;
      ++floating;
      most = std::max(most, std::abs(plant.i_abc().b - before));
    }
    EXPECT_GT(floating, 100);
    EXPECT_LT(most, 1e-7);
  }
}

TEST(Saturation, OpenStatorCarriesNoCurrentWhileTheFluxDecays) {
  Plant plant = plant_with({1.0, 7, 0.0});
  const InductionMachineParameters<> m;
  const SpaceVector<> psi_r = polar(1.2, 0.7);
  plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
  PlantInputs<> inputs = supply();
  inputs.imposed_speed = true;
  ASSERT_LT(magnitude(plant.i_s()), 1e-9);
  FixedStepIntegrator<Plant> integrator;
  const double energy = plant.magnetic_energy();
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(2000, gates_off), inputs));
  EXPECT_LT(magnitude(plant.i_s()), 1e-7);
  EXPECT_LT(magnitude(plant.psi_r()), 1.0);
  const double lost = plant.state()[Plant::appended + int(Meter::rotor_copper)];
  EXPECT_NEAR(energy - plant.magnetic_energy(), lost, 1e-7 * energy);
}

double unaccounted(const Plant& plant) {
  const auto energy = [&](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
  const double in = energy(Meter::dc_link);
  const double lost = energy(Meter::stator_copper) + energy(Meter::rotor_copper);
  return std::abs(in - lost - energy(Meter::mechanical) - plant.magnetic_energy()) / (std::abs(in) + lost);
}

void expect_closed_energy(PlantIntegrator<Plant>& integrator, std::size_t periods, double limit) {
  for (const Parameters& p : cases) {
    SCOPED_TRACE(p.knee);
    Plant plant = plant_with(p);
    integrator.reset();
    ASSERT_TRUE(run(plant, integrator, switching_sequence(periods, 11), supply()));
    EXPECT_LT(unaccounted(plant), limit);
    ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(200, gates_off), supply()));
    std::vector<SwitchState> open_phase = switching_sequence(2000, 12);
    for (SwitchState& state : open_phase) state = {state.a(), LegState::off, state.c()};
    ASSERT_TRUE(run(plant, integrator, open_phase, supply()));
    EXPECT_LT(unaccounted(plant), limit);
  }
}

TEST(Saturation, EnergyClosesOverSecondsWithCvode) {
  CvodeIntegrator<Plant> integrator;
  expect_closed_energy(integrator, 80'000, 1e-5);
}

TEST(Saturation, EnergyClosesWithNewtonsIteration) {
  CvodeParameters parameters;
  parameters.method = CvodeMethod::bdf_newton;
  CvodeIntegrator<Plant> integrator{parameters};
  expect_closed_energy(integrator, 8'000, 1e-5);
}

TEST(Saturation, EnergyClosesWithTheFixedStep) {
  FixedStepIntegrator<Plant> integrator;
  expect_closed_energy(integrator, 20'000, 1e-5);
}

/// A symmetric pattern of seven segments, between the active vectors `sixth` and the next one.
std::vector<GateSegment> symmetric(std::size_t sixth, std::int32_t quarter_ns, double share) {
  const auto first = std::int32_t(share * quarter_ns);
  const SwitchState a = switch_states[1 + sixth % 6], b = switch_states[1 + (sixth + 1) % 6];
  const SwitchState low = switch_states[0], high = switch_states[7];
  const std::int32_t second = quarter_ns - first;
  return {{low, quarter_ns / 2}, {a, first}, {b, second},          {high, quarter_ns},
          {b, second},           {a, first}, {low, quarter_ns / 2}};
}

/// Torque at the end of each period. [N·m]
std::vector<double> torques(const Parameters& p, PlantIntegrator<Plant>& integrator, std::int32_t period_ns) {
  Plant plant = plant_with(p);
  integrator.reset();
  std::vector<double> tau_e;
  const auto periods_per_sixth = std::size_t(3'300'000 / period_ns);
  for (std::size_t n = 0; n < 24 * periods_per_sixth; ++n) {
    const auto segments = symmetric(n / periods_per_sixth, period_ns / 4,
                                    1.0 - double(n % periods_per_sixth) / double(periods_per_sixth));
    PlantInputs<> inputs = supply();
    inputs.state = segments[0].state;
    plant.set_inputs(inputs);
    if (!integrator.advance_through(plant, segments, {})) return {};
    tau_e.push_back(plant.tau_e());
  }
  return tau_e;
}

TEST(Saturation, IntegratorsAgreeOverSwitching) {
  for (const Parameters& p : cases) {
    for (const std::int32_t period_ns : {25'000, 100'000}) {
      SCOPED_TRACE(std::to_string(p.knee) + " Wb, " + std::to_string(period_ns) + " ns");
      FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000, AtSwitching::stop}};
      const std::vector<double> truth = torques(p, fine, period_ns);
      double peak = 0;
      for (const double tau : truth) peak = std::max(peak, std::abs(tau));
      EXPECT_GT(peak, 20);
      FixedStepIntegrator<Plant> fixed;
      CvodeIntegrator<Plant> cvode;
      ErkIntegrator<Plant> erk;
      for (PlantIntegrator<Plant>* integrator : std::vector<PlantIntegrator<Plant>*>{&fixed, &cvode, &erk}) {
        const std::vector<double> found = torques(p, *integrator, period_ns);
        ASSERT_EQ(found.size(), truth.size());
        double error = 0;
        for (std::size_t n = 0; n < truth.size(); ++n) error = std::max(error, std::abs(found[n] - truth[n]));
        EXPECT_LT(error, (period_ns > 25'000 ? 1e-4 : 1e-5) * peak);
      }
    }
  }
}

TEST(Saturation, FloatAgreesWithDouble) {
  const InductionMachine<double> d{InductionMachineParameters<double>{}, {1.1, 7, 1.0}};
  const InductionMachine<float> f{InductionMachineParameters<float>{}, {1.1F, 7, 1.0F}};
  const SpaceVector<float> i = f.stator_current({1.0F, 0.5F}, {0.8F, 0.6F});
  const SpaceVector<double> expected = d.stator_current({1.0, 0.5}, {0.8, 0.6});
  EXPECT_NEAR(double(i.alpha), expected.alpha, 1e-4 * magnitude(expected));
  EXPECT_NEAR(double(i.beta), expected.beta, 1e-4 * magnitude(expected));
}

}  // namespace
}  // namespace sextant
