// Threshold voltage and slope resistance of the plant's inverter against independent references: the
// potentials of the legs by an iteration, currents of a machine at rest in closed form, all integrators
// against a fine one.
#include "sextant/plant/conduction_drops.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
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
using Potentials = std::array<double, 3>;

/// Lowest and highest potential of a leg. [V]
struct Bounds {
  double low;
  double high;
};

Bounds bounds_of(LegState state, double i, double u_dc, double threshold) {
  const double low = (state == LegState::high ? u_dc : 0.0) - threshold;
  const double high = (state == LegState::low ? 0.0 : u_dc) + threshold;
  return i > 0 ? Bounds{low, low} : i < 0 ? Bounds{high, high} : Bounds{low, high};
}

/// The potentials at which each leg without current either keeps it at zero,  v_x = ½ (v_y + v_z) + 3/2 e_x,
/// or is at the end of its range, by projected relaxation.
SpaceVector<> relaxed_voltage(const std::array<Bounds, 3>& bounds, const Potentials& e) {
  Potentials v{bounds[0].low, bounds[1].low, bounds[2].low};
  for (int n = 0; n < 100; ++n) {
    for (std::size_t x = 0; x < 3; ++x) {
      const double free = 0.5 * (v[(x + 1) % 3] + v[(x + 2) % 3]) + 1.5 * e[x];
      v[x] = std::clamp(free, bounds[x].low, bounds[x].high);
    }
  }
  return clarke(ThreePhase<>{v[0], v[1], v[2]});
}

TEST(ConductionDrops, TheLegsOfAnInverterTakeThePotentialsThatTheirCurrentsAllow) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  const auto draw = [&random](double most) {
    return std::uniform_real_distribution<double>{-most, most}(random);
  };
  constexpr std::array<LegState, 3> leg{LegState::low, LegState::high, LegState::off};
  for (int n = 0; n < 5'000; ++n) {
    const double u_dc = n % 3 == 0 ? 5.0 : 530.0;
    const double threshold = std::array{0.0, 1.2, 20.0}[random() % 3];
    const SwitchState state{leg[random() % 3], leg[random() % 3], leg[random() % 3]};
    const double size = std::pow(10.0, 1.5 + draw(1.5));
    const ThreePhase<> emf = inverse_clarke(SpaceVector<>{draw(size), draw(size)});
    // None flows, or in two legs, or in all.
    Potentials i{};
    const std::size_t kind = random() % 3;
    if (kind > 0) i = {draw(20), kind == 1 ? 0.0 : draw(20), 0};
    i[2] = -i[0] - i[1];
    std::rotate(i.begin(), i.begin() + std::ptrdiff_t(random() % 3), i.end());
    if (std::ranges::any_of(i, [](double x) { return x != 0 && std::abs(x) < 1e-3; })) continue;

    Inverter<double> inverter{threshold};
    const SpaceVector<> i_s = clarke(ThreePhase<>{i[0], i[1], i[2]});
    const SpaceVector<> e = clarke(emf);
    inverter.set(state, u_dc, i_s, e);
    const SpaceVector<> u_s = inverter.voltage_map()(e);

    const std::array<LegState, 3> states{state.a(), state.b(), state.c()};
    std::array<Bounds, 3> bounds{};
    for (std::size_t x = 0; x < 3; ++x) bounds[x] = bounds_of(states[x], i[x], u_dc, threshold);
    const SpaceVector<> expected = relaxed_voltage(bounds, {emf.a, emf.b, emf.c});
    ASSERT_LT(magnitude(u_s - expected), 4 * Inverter<double>::voltage_tolerance)
        << n << ": threshold " << threshold << ", currents " << i[0] << ", " << i[1] << ", " << i[2];
    const double loss = ConductionDrops<double>{.threshold_voltage = threshold}.threshold_loss(i_s);
    ASSERT_NEAR(u_dc * inverter.dc_link_current(i_s), 1.5 * dot(u_s, i_s) + loss, 1e-3);
  }
}

constexpr ConductionDrops<double> drops{.threshold_voltage = 1.2, .slope_resistance = 0.02};

Plant plant_of(const ConductionDrops<double>& of) {
  DrivePlantParameters<double> parameters{};
  parameters.drops = of;
  return Plant{parameters, Meter{}};
}

struct Contestant {
  std::string name;
  std::unique_ptr<PlantIntegrator<Plant>> integrator;
};

std::vector<Contestant> contestants() {
  CvodeParameters cvode{};
  cvode.relative_tolerance = 1e-10;
  cvode.flux_tolerance = 1e-12;
  ErrorControl erk{};
  erk.relative_tolerance = 1e-10;
  erk.flux_tolerance = 1e-12;
  std::vector<Contestant> list;
  list.push_back({"cvode", std::make_unique<CvodeIntegrator<Plant>>(cvode)});
  list.push_back({"erk", std::make_unique<ErkIntegrator<Plant>>(erk)});
  list.push_back({"fixed", std::make_unique<FixedStepIntegrator<Plant>>()});
  list.push_back({"exact", std::make_unique<ExactIntegrator<Plant>>()});
  return list;
}

// Vector 1 puts leg a to the upper rail: positive current of a passes its threshold, negative ones of b and c
// theirs. Less than two thresholds drive no current, more than that the resistances in series: at the current
// 2/3 (u_dc − 2 V_t)/(R_s + r) the machine rests.
TEST(ConductionDrops, ALinkBelowTwoThresholdsDrivesNoCurrent) {
  for (Contestant& c : contestants()) {
    SCOPED_TRACE(c.name);
    for (const double u_dc : {2.3, 5.4}) {
      Plant plant = plant_of(drops);
      PlantInputs<double> inputs = supply();
      inputs.u_dc = u_dc;
      inputs.imposed_speed = true;
      const InductionMachineParameters<double> m = DrivePlantParameters<double>{}.machine;
      const double expected = u_dc < 2.4 ? 0.0 : 2.0 / 3.0 * (u_dc - 2.4) / (m.r_s + drops.slope_resistance);
      plant.set_fluxes({m.l_s() * expected, 0}, {m.l_m * expected, 0});
      c.integrator->reset();
      ASSERT_TRUE(run(plant, *c.integrator, std::vector<SwitchState>(4'000, switch_states[1]), inputs));
      EXPECT_NEAR(plant.i_s().alpha, expected, 1e-9);
      EXPECT_NEAR(plant.i_s().beta, 0.0, 1e-9);
    }
  }
}

/// Driven through the zeros of its currents, gates off, driven, one leg off.
void go(Plant& plant, PlantIntegrator<Plant>& integrator) {
  const PlantInputs<double> inputs = supply();
  ASSERT_TRUE(run(plant, integrator, switching_sequence(2000, 11), inputs));
  ASSERT_TRUE(run(plant, integrator, std::vector<SwitchState>(100, gates_off), inputs));
  ASSERT_TRUE(run(plant, integrator, switching_sequence(1500, 13), inputs));
  std::vector<SwitchState> one_off = switching_sequence(500, 12);
  for (SwitchState& state : one_off) state = {state.a(), LegState::off, state.c()};
  ASSERT_TRUE(run(plant, integrator, one_off, inputs));
}

TEST(ConductionDrops, AllIntegratorsMoveTheSamePlantAndItsEnergyBalances) {
  for (const ConductionDrops<double>& of : {drops, ConductionDrops<double>{.slope_resistance = 0.2}}) {
    SCOPED_TRACE(testing::Message() << "threshold " << of.threshold_voltage);
    Plant reference = plant_of(of);
    FixedStepIntegrator<Plant> fine{FixedStepParameters{1'000}};
    go(reference, fine);
    Plant ideal = plant_of({});
    go(ideal, fine);
    EXPECT_GT(magnitude(ideal.psi_s() - reference.psi_s()), 5e-3);
    for (const Contestant& c : contestants()) {
      SCOPED_TRACE(c.name);
      Plant plant = plant_of(of);
      go(plant, *c.integrator);
      EXPECT_LT(magnitude(plant.psi_s() - reference.psi_s()), 2e-6);
      EXPECT_LT(magnitude(plant.psi_r() - reference.psi_r()), 2e-6);
      EXPECT_NEAR(plant.omega_m(), reference.omega_m(), 2e-5);
      const auto energy = [&](Meter::Index n) { return plant.state()[Plant::appended + int(n)]; };
      const double lost = energy(Meter::stator_copper) + energy(Meter::rotor_copper);
      const double in = energy(Meter::dc_link);
      const double out = lost + energy(Meter::mechanical) + plant.magnetic_energy();
      EXPECT_GT(lost, 1.0);
      EXPECT_NEAR(in, out, 2e-4 * (std::abs(in) + lost));
    }
  }
}

TEST(ConductionDrops, AreFiniteAndNotBelowZero) {
  using Drops = ConductionDrops<double>;
  EXPECT_EQ(drops.validate(), nullptr);
  EXPECT_EQ(Drops{}.validate(), nullptr);
  EXPECT_FALSE(Drops{}.act());
  for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_STREQ(Drops{.threshold_voltage = wrong}.validate(),
                 "the threshold voltage of the inverter must be finite and not below zero");
    EXPECT_STREQ(Drops{.slope_resistance = wrong}.validate(),
                 "the slope resistance of the inverter must be finite and not below zero");
  }
}

}  // namespace
}  // namespace sextant
