// Main flux by a table and leakage that saturates, alone and together, against the Γ circuit, published
// interpolation, differences and energy.
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
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

using ::testing::HasSubstr;
using Meter = EnergyMeter<double>;
using Plant = DrivePlant<double, Meter>;
using Machine = InductionMachine<>;
using Points = std::vector<std::pair<double, double>>;

/// A measured curve with a foot: the inductance rises from 75 mH to 95 mH before it falls to 45 mH.
const Points with_foot{{0.3, 4.0}, {0.6, 6.5}, {0.9, 9.5}, {1.05, 12.5}, {1.2, 19.0}, {1.3, 29.0}};
/// One that only bends upwards.
const Points convex{{0.5, 5.5}, {0.9, 10.5}, {1.1, 16.0}, {1.25, 28.0}};

struct Case {
  std::string name;
  SaturationParameters<> law{};
  MagnetisingPoints<> points{};
  LeakageSaturation<> leakage{};

  [[nodiscard]] DrivePlantParameters<> parameters() const {
    DrivePlantParameters<> p;
    p.saturation = law;
    p.points = points;
    p.leakage = leakage;
    return p;
  }
  [[nodiscard]] Machine machine() const { return Machine{{}, law, {}, points, leakage}; }
  [[nodiscard]] Plant plant() const {
    const DrivePlantParameters<> p = parameters();
    return Plant{p, Meter{}};
  }
  /// Of the Γ circuit, as law, published interpolation or machine have it. [A]
  [[nodiscard]] double magnetising_current(double psi) const {
    const InductionMachineParameters<> m;
    if (points.acts()) return MagnetisingTable<>{points}.by_flux(psi) * psi;
    const double bent = law.acts() ? 1 + std::pow(psi / law.knee, law.exponent) : 1;
    return bent * psi / m.l_s();
  }
  [[nodiscard]] double leakage_current(double psi) const {
    const InductionMachineParameters<> m;
    const double gamma = m.l_s() / m.l_m;
    const double bent = leakage.acts() ? 1 + std::pow(psi / leakage.knee, leakage.exponent) : 1;
    return bent * psi / (gamma * m.l_ls + gamma * gamma * m.l_lr);
  }
};

std::vector<Case> cases() {
  return {{.name = "foot", .points = {with_foot}},
          {.name = "convex", .points = {convex}},
          {.name = "leakage", .leakage = {0.12, 2}},
          {.name = "law_and_leakage", .law = {1.1, 7, 0.0}, .leakage = {0.2, 5}},
          {.name = "foot_and_leakage", .points = {with_foot}, .leakage = {0.15, 3}}};
}

class Magnetics : public ::testing::TestWithParam<Case> {
 protected:
  static constexpr unsigned seed = 20261128;
  void SetUp() override { RecordProperty("seed", int(seed)); }
  double draw(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }
  SpaceVector<> vector(double most) { return {draw(-most, most), draw(-most, most)}; }
  /// Near a stator flux, where the leakage is.
  SpaceVector<> rotor_flux(SpaceVector<> psi_s) { return 0.97 * psi_s + vector(0.25); }

 private:
  std::mt19937 random_{seed};
};

INSTANTIATE_TEST_SUITE_P(Of, Magnetics, ::testing::ValuesIn(cases()),
                         [](const auto& of) { return of.param.name; });

TEST_P(Magnetics, AreTheGammaCircuit) {
  const InductionMachineParameters<> m;
  const Machine machine = GetParam().machine();
  EXPECT_FALSE(machine.is_linear());
  const double gamma = m.l_s() / m.l_m;
  for (int n = 0; n < 200; ++n) {
    const SpaceVector<> psi_s = vector(1.2), psi_r = rotor_flux(psi_s);
    const SpaceVector<> psi_sigma = psi_s - gamma * psi_r;
    const SpaceVector<> leakage = GetParam().leakage_current(magnitude(psi_sigma)) * direction(psi_sigma);
    const SpaceVector<> i_s = GetParam().magnetising_current(magnitude(psi_s)) * direction(psi_s) + leakage;
    EXPECT_LT(magnitude(machine.stator_current(psi_s, psi_r) - i_s), 1e-10 * (1 + magnitude(i_s)));
    EXPECT_LT(magnitude(machine.rotor_current(psi_s, psi_r) + gamma * leakage),
              1e-10 * (1 + magnitude(leakage)));
  }
}

TEST_P(Magnetics, FluxFollowsFromCurrent) {
  const Machine machine = GetParam().machine();
  for (int n = 0; n < 500; ++n) {
    const SpaceVector<> psi_s = vector(1.8), psi_r = n % 2 == 0 ? rotor_flux(psi_s) : vector(1.5);
    const SpaceVector<> i_s = machine.stator_current(psi_s, psi_r);
    EXPECT_LT(magnitude(machine.stator_flux(i_s, psi_r) - psi_s), 1e-11 * (1 + magnitude(psi_s)));
  }
  EXPECT_EQ(magnitude(machine.stator_flux({}, {})), 0.0);
}

// The field is passive: what the windings deliver is the change of a function of the fluxes.
TEST_P(Magnetics, CurrentsAreTheGradientOfTheFieldsEnergy) {
  const Machine machine = GetParam().machine();
  for (int n = 0; n < 200; ++n) {
    const SpaceVector<> psi_s = vector(1.0), psi_r = rotor_flux(psi_s);
    const SpaceVector<> along_s = vector(1.0), along_r = vector(1.0);
    constexpr double h = 1e-5;
    const auto energy = [&](double x) {
      return machine.magnetic_energy(psi_s + x * along_s, psi_r + x * along_r);
    };
    const double numeric = (energy(h) - energy(-h)) / (2 * h);
    const double power = 1.5 * (dot(machine.stator_current(psi_s, psi_r), along_s) +
                                dot(machine.rotor_current(psi_s, psi_r), along_r));
    EXPECT_NEAR(numeric, power, 1e-6 * (1 + std::abs(power) + std::abs(energy(0))));
    EXPECT_GT(energy(0), 0);
  }
  EXPECT_EQ(machine.magnetic_energy({}, {}), 0);
}

TEST_P(Magnetics, InverseInductanceIsTheSlopeOfTheCurrent) {
  const Machine machine = GetParam().machine();
  for (int n = 0; n < 200; ++n) {
    const SpaceVector<> psi_s = vector(1.2), psi_r = rotor_flux(psi_s);
    const auto inverse = machine.inverse_inductance(psi_s, psi_r);
    EXPECT_GT(inverse.across, 0);
    EXPECT_GE(inverse.added_along, 0);
    const SpaceVector<> step = vector(1.0);
    const SpaceVector<> numeric = 0.5e6 * (machine.stator_current(psi_s + 1e-6 * step, psi_r) -
                                           machine.stator_current(psi_s - 1e-6 * step, psi_r));
    // Between the pieces of a table the slope has a corner.
    EXPECT_LT(magnitude(inverse(step) - numeric), 1e-5 * (inverse.across + inverse.added_along));
    EXPECT_LT(magnitude(inverse.flux(inverse(step)) - step), 1e-12);
  }
}

TEST_P(Magnetics, JacobianIsTheDerivativeOfTheRightHandSide) {
  Plant plant = GetParam().plant();
  for (int n = 0; n < 100; ++n) {
    Plant::State x = Plant::State::Zero();
    const SpaceVector<> psi_s = vector(1.0), psi_r = rotor_flux(psi_s);
    x.head<4>() << psi_s.alpha, psi_s.beta, psi_r.alpha, psi_r.beta;
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
                2e-5 * (1 + numeric.cwiseAbs().maxCoeff()))
          << n << ' ' << c;
    }
  }
}

// The EMF is found with the inductance of each direction: else a floating leg would carry current.
TEST_P(Magnetics, CurrentOfAFloatingLegStaysZero) {
  Plant plant = GetParam().plant();
  FixedStepIntegrator<Plant> integrator{FixedStepParameters{5'000}};
  PlantInputs<> inputs = supply();
  inputs.imposed_speed = true;
  const SpaceVector<> psi_r = polar(1.15, 0.7);
  plant.set_fluxes(plant.machine().stator_flux({}, psi_r), psi_r);
  plant.set_speed(10);
  int floating = 0;
  double most = 0;
  for (const SwitchState state : switching_sequence(2000, 12)) {
    inputs.state = {state.a(), LegState::off, state.c()};
    plant.set_inputs(inputs);
    const bool floats = plant.inverter().ties()[1] == LegTie::floating;
    const double before = plant.i_abc().b;
    ASSERT_TRUE(integrator.advance(plant, 5'000));
    if (!floats || plant.inverter().ties()[1] != LegTie::floating) continue;
    ++floating;
    most = std::max(most, std::abs(plant.i_abc().b - before));
  }
  EXPECT_GT(floating, 50);
  EXPECT_LT(most, 2e-5);  // at a point of a table the inductance has a corner, within a step of 5 µs
}

// At a stator flux and leakage the machine is slower than its bounds, by which fixed steps are chosen.
TEST_P(Magnetics, RatesAreBounds) {
  Plant plant = GetParam().plant();
  const Machine machine = GetParam().machine();
  const InductionMachineParameters<> m;
  for (int n = 0; n < 200; ++n) {
    const SpaceVector<> psi_s = vector(1.2), psi_r = rotor_flux(psi_s);
    const double h = 1e-6;
    const auto turned = [&](double angle) {
      return std::cos(angle) * psi_r + std::sin(angle) * rotate_90(psi_r);
    };
    const auto torque = [&](double angle) {
      return machine.torque(psi_s, machine.stator_current(psi_s, turned(angle)));
    };
    const double slope = m.pole_pairs * (torque(h) - torque(-h)) / (2 * h);
    EXPECT_LE(std::abs(slope),
              1.0001 * machine.angle_gain(psi_s, psi_r) * magnitude(psi_s) * magnitude(psi_r));
    Plant::State x = Plant::State::Zero();
    x.head<4>() << psi_s.alpha, psi_s.beta, psi_r.alpha, psi_r.beta;
    PlantInputs<> inputs = supply();
    inputs.imposed_speed = true;
    inputs.state = switch_states[1];
    plant.set_inputs(inputs);
    Plant::Jacobian j;
    plant.jacobian(x, j);
    const Eigen::Matrix<double, 4, 4> block = j.topLeftCorner<4, 4>();
    EXPECT_LE(block.eigenvalues().cwiseAbs().maxCoeff(), 1.0001 * machine.damping(psi_s, psi_r));
  }
}

double unaccounted(const Plant& plant) {
  const auto energy = [&](Meter::Index i) { return plant.state()[Plant::appended + int(i)]; };
  const double in = energy(Meter::dc_link);
  const double lost = energy(Meter::stator_copper) + energy(Meter::rotor_copper);
  return std::abs(in - lost - energy(Meter::mechanical) - plant.magnetic_energy()) / (std::abs(in) + lost);
}

TEST_P(Magnetics, EnergyCloses) {
  CvodeIntegrator<Plant> cvode;
  CvodeParameters with_newton;
  with_newton.method = CvodeMethod::bdf_newton;
  CvodeIntegrator<Plant> newton{with_newton};
  FixedStepIntegrator<Plant> fixed;
  for (PlantIntegrator<Plant>* integrator : std::vector<PlantIntegrator<Plant>*>{&cvode, &newton, &fixed}) {
    Plant plant = GetParam().plant();
    ASSERT_TRUE(run(plant, *integrator, switching_sequence(4000, 11), supply()));
    EXPECT_LT(unaccounted(plant), 1e-5);
    ASSERT_TRUE(run(plant, *integrator, std::vector<SwitchState>(100, gates_off), supply()));
    EXPECT_LT(unaccounted(plant), 1e-5);
  }
}

/// By scipy.interpolate.PchipInterpolator of the points and of their mirror image: current, its slope and its
/// integral from zero.
struct Reference {
  double psi, current, slope, energy;
};
const std::vector<Reference> by_scipy{
    {0.1, 1.4017094017094, 14.3589743589744, 0.0692307692307692},
    {0.3, 4, 10.2564102564103, 0.623076923076923},
    {0.45, 5.29370629370629, 7.66317016317016, 1.32496722027972},
    {0.77, 8.01042424242424, 9.62191142191142, 3.43892541181041},
    {0.9, 9.5, 13.8461538461538, 4.57115384615385},
    {1, 11.2678812415654, 22.051282051282, 5.60271030139451},
    {1.11, 14.4848903788133, 39.2431780087161, 7.00178387941927},
    {1.2, 19, 62.1019108280255, 8.49317430181284},
    {1.27, 25.4280420382166, 114.093036093418, 10.026926063667},
    {1.3, 29, 122.666666666667, 10.8427036719473},
};

TEST(MagnetisingTable, IsThatOfScipy) {
  const MagnetisingTable<> table{MagnetisingPoints<>{with_foot}};
  for (const Reference& r : by_scipy) {
    SCOPED_TRACE(r.psi);
    EXPECT_NEAR(table.by_flux(r.psi) * r.psi, r.current, 1e-12 * r.current);
    EXPECT_NEAR(table.slope(r.psi), r.slope, 1e-12 * r.slope);
    EXPECT_NEAR(table.energy(r.psi), r.energy, 1e-12 * r.energy);
  }
  const Reference& end = by_scipy.back();
  EXPECT_NEAR(table.by_flux(1.5) * 1.5, end.current + 0.2 * end.slope, 1e-11) << "a line beyond the end";
  EXPECT_NEAR(table.energy(1.5), end.energy + 0.2 * end.current + 0.02 * end.slope, 1e-11);
}

TEST(MagnetisingTable, NoLoadCurrentsAreThePoints) {
  const InductionMachineParameters<> m;
  for (const Points& points : {with_foot, convex}) {
    const Machine machine{m, {}, {}, {points}};
    for (const auto& [psi, current] : points) {
      const SpaceVector<> psi_s = polar(psi, 2.0);
      EXPECT_LT(magnitude(machine.stator_current(psi_s, (m.l_m / m.l_s()) * psi_s) - polar(current, 2.0)),
                1e-10);
    }
  }
}

TEST(MagnetisingTable, LargestInductanceIsABound) {
  for (const Points& points : {with_foot, convex}) {
    const MagnetisingTable<> table{MagnetisingPoints<>{points}};
    double most = 0;
    for (double psi = 1e-6; psi < 1.6; psi += 1e-4) most = std::max(most, 1 / table.by_flux(psi));
    EXPECT_GE(table.largest_inductance(), most);
    EXPECT_LE(table.largest_inductance(), 1.04 * most);
  }
}

// A line through zero is the linear machine, up to rounding.
TEST(MagnetisingTable, APointsLineIsTheMachine) {
  const double l_s = InductionMachineParameters<>{}.l_s();
  const MagnetisingPoints<> line{{{1.0, 1.0 / l_s}, {1.5, 1.50000001 / l_s}}};
  ASSERT_EQ(line.validate(), nullptr);
  const Machine machine{{}, {}, {}, line}, linear{InductionMachineParameters<>{}};
  const SpaceVector<> psi_s{0.8, -0.3}, psi_r{0.7, -0.4};
  EXPECT_LT(magnitude(machine.stator_current(psi_s, psi_r) - linear.stator_current(psi_s, psi_r)), 1e-6);
  EXPECT_NEAR(machine.magnetic_energy(psi_s, psi_r), linear.magnetic_energy(psi_s, psi_r), 1e-6);
}

TEST(MagnetisingTable, BadPointsAreRefused) {
  const auto problem = [](const Points& points) {
    DrivePlantParameters<> p;
    p.points = {points};
    const char* const text = p.validate();
    return std::string{text == nullptr ? "" : text};
  };
  EXPECT_EQ(problem({}), "");
  EXPECT_EQ(problem(with_foot), "");
  EXPECT_EQ(problem(convex), "");
  EXPECT_THAT(problem({{1, 10}}), HasSubstr("from 2 to 24"));
  EXPECT_THAT(problem(Points(25, {1, 1})), HasSubstr("from 2 to 24"));
  EXPECT_THAT(problem({{0, 0}, {1, 10}, {1.2, 20}}), HasSubstr("must rise from above zero"));
  EXPECT_THAT(problem({{1, 10}, {1, 20}}), HasSubstr("must rise from above zero"));
  EXPECT_THAT(problem({{1, 10}, {1.1, 10}}), HasSubstr("must rise from above zero"));
  EXPECT_THAT(problem({{1, 10}, {NAN, 20}}), HasSubstr("must rise from above zero"));
  EXPECT_THAT(problem({{1, 10}, {1.2, INFINITY}}), HasSubstr("must rise from above zero"));
  EXPECT_THAT(problem({{1, 10}, {1.2, 11}}), HasSubstr("must end where"));
  EXPECT_THAT(problem({{1, 1}, {1.2, 10}}), HasSubstr("more than ten times"));
  DrivePlantParameters<> both;
  both.points = {convex};
  both.saturation.knee = 1;
  EXPECT_THAT(both.validate(), HasSubstr("not by both"));
}

TEST(LeakageSaturation, ParametersAreChecked) {
  const auto problem = [](const LeakageSaturation<>& leakage) {
    DrivePlantParameters<> p;
    p.leakage = leakage;
    const char* const text = p.validate();
    return std::string{text == nullptr ? "" : text};
  };
  EXPECT_EQ(problem({}), "");
  EXPECT_EQ(problem({0.1, 20}), "");
  EXPECT_THAT(problem({-1, 2}), HasSubstr("knee of the leakage"));
  EXPECT_THAT(problem({NAN, 2}), HasSubstr("knee of the leakage"));
  EXPECT_THAT(problem({0.1, 1}), HasSubstr("exponent of the leakage"));
  EXPECT_THAT(problem({0.1, 21}), HasSubstr("exponent of the leakage"));
}

// With a blocked rotor and little main flux the terminals show a leakage inductance of half at the knee.
TEST(LeakageSaturation, AtTheKneeTheInductanceIsHalf) {
  const InductionMachineParameters<> m;
  const Machine machine{m, {}, {}, {}, {0.1, 4}}, linear{m};
  const SpaceVector<> psi_s{0.1, 0}, none{};  // all of it leakage
  const double gamma = m.l_s() / m.l_m;
  const double l_sigma = gamma * m.l_ls + gamma * gamma * m.l_lr;
  EXPECT_NEAR(machine.stator_current(psi_s, none).alpha, 0.1 / m.l_s() + 2 * 0.1 / l_sigma, 1e-10);
  EXPECT_NEAR(machine.rotor_current(psi_s, none).alpha, 2 * linear.rotor_current(psi_s, none).alpha, 1e-10);
}

TEST(LeakageSaturation, OffItIsTheSameToTheBit) {
  const Machine linear{InductionMachineParameters<>{}}, off{{}, {}, {}, {}, {0.0, 9}};
  EXPECT_TRUE(off.is_linear());
  const Machine law{{}, {1.1, 7, 0.0}}, law_off{{}, {1.1, 7, 0.0}, {}, {}, {0.0, 9}};
  for (double a = -1; a < 1; a += 0.1) {
    const SpaceVector<> psi_s{a, 0.7}, psi_r{0.8 * a, 0.5};
    EXPECT_EQ(linear.stator_current(psi_s, psi_r), off.stator_current(psi_s, psi_r));
    EXPECT_EQ(linear.rotor_current(psi_s, psi_r), off.rotor_current(psi_s, psi_r));
    EXPECT_EQ(law.stator_current(psi_s, psi_r), law_off.stator_current(psi_s, psi_r));
    EXPECT_EQ(law.magnetic_energy(psi_s, psi_r), law_off.magnetic_energy(psi_s, psi_r));
    EXPECT_EQ(law.damping(psi_s, psi_r), law_off.damping(psi_s, psi_r));
  }
}

// Over a table the integrators agree, whose order a corner of di/dψ must not spoil.
TEST(MagnetisingTable, IntegratorsAgree) {
  const Case with{.name = "", .points = {with_foot}, .leakage = {0.15, 3}};
  Plant truth = with.plant();
  FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000, AtSwitching::stop}};
  const std::vector<SwitchState> sequence = switching_sequence(1500, 7);
  ASSERT_TRUE(run(truth, fine, sequence, supply()));
  CvodeIntegrator<Plant> cvode;
  ErkIntegrator<Plant> erk;
  FixedStepIntegrator<Plant> fixed;
  for (PlantIntegrator<Plant>* integrator : std::vector<PlantIntegrator<Plant>*>{&cvode, &erk, &fixed}) {
    Plant plant = with.plant();
    ASSERT_TRUE(run(plant, *integrator, sequence, supply()));
    EXPECT_LT((plant.state().head<4>() - truth.state().head<4>()).norm(), 2e-5);
  }
}

TEST(MagnetisingTable, FloatAgreesWithDouble) {
  const InductionMachine<float> f{{}, {}, {}, {{{0.5F, 5.5F}, {0.9F, 10.5F}, {1.1F, 16.0F}}}, {0.2F, 3}};
  const Machine d{{}, {}, {}, {{{0.5, 5.5}, {0.9, 10.5}, {1.1, 16.0}}}, {0.2, 3}};
  const SpaceVector<float> i = f.stator_current({1.0F, 0.3F}, {0.9F, 0.2F});
  const SpaceVector<double> expected = d.stator_current({1.0, 0.3}, {0.9, 0.2});
  EXPECT_NEAR(double(i.alpha), expected.alpha, 1e-4 * magnitude(expected));
  EXPECT_NEAR(double(i.beta), expected.beta, 1e-4 * magnitude(expected));
}

}  // namespace
}  // namespace sextant
