// The dead time of the simulated inverter against its analytic law. A leg that carries i_x > 0 keeps the
// potential of the lower rail through its dead times, one that carries i_x < 0 that of the upper rail: a
// rising edge costs u_dc t_d at i_x > 0 and nothing at i_x < 0, a falling edge gains u_dc t_d at i_x < 0 and
// nothing at i_x > 0. A modulated leg, which changes twice a period, so loses sign(i_x) u_dc t_d of its
// volt-seconds.
#include "sextant/power_stage/dead_time.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr std::int32_t dead_ns = 1'500;
constexpr double u_dc = 530.0;
constexpr auto low = LegState::low;
constexpr auto high = LegState::high;
constexpr auto off = LegState::off;

/// Legs a, b, c rise in this order and fall in the opposite one, each high for the given time. [ns]
GatePattern modulated(std::int32_t a_ns, std::int32_t b_ns, std::int32_t c_ns) {
  const std::array<std::int32_t, 4> times{period_ns - a_ns, a_ns - b_ns, b_ns - c_ns, c_ns};
  const std::array<SwitchState, 4> states{switch_states[0], switch_states[1], switch_states[2],
                                          switch_states[7]};
  GatePattern p;
  for (std::size_t n = 0; n < 3; ++n) p.append({states[n], times[n] / 2});
  p.append({states[3], times[3]});
  for (std::size_t n = 3; n-- > 0;) p.append({states[n], times[n] - times[n] / 2});
  return p;
}

SimulatedPowerStage::Parameters stage_of(IntegratorKind integrator, std::int32_t dead_time_ns) {
  SimulatedPowerStage::Parameters p;
  p.integrator = integrator;
  p.io.u_dc = u_dc;
  p.io.dead_time_ns = dead_time_ns;
  p.cvode.relative_tolerance = p.erk.relative_tolerance = 1e-9;
  return p;
}

/// Change of the stator flux over a period of the pattern that follows one of a zero vector, from these phase
/// currents. [Wb]
SpaceVector<> flux_change(IntegratorKind integrator, std::int32_t dead_time_ns, const ThreePhase<>& i,
                          const GatePattern& pattern) {
  using Stage = SimulatedPowerStage;
  const Stage::Parameters parameters = stage_of(integrator, dead_time_ns);
  const MechanicalLoad standstill{{.imposed_speed = ProfileParameters{.value = 0.0}}};
  Stage::Plant plant{parameters.plant};
  const auto moves = Stage::make_integrator(parameters);
  Stage::Io io{parameters.io, plant, *moves, standstill};
  static_cast<void>(io.read(0));
  io.write({switch_states[0], period_ns});
  static_cast<void>(io.read(period_ns));
  const SpaceVector<> i_s = clarke(i);
  const InductionMachineParameters<> m = plant.machine().parameters();
  // No rotor current: the flux of the stator current in both windings.
  plant.set_fluxes(m.l_s() * i_s, m.l_m * i_s);
  const SpaceVector<> before = plant.psi_s();
  io.write(pattern);
  const Measurement<> measured = io.read(2 * period_ns);
  EXPECT_TRUE(measured.plausible);
  EXPECT_EQ(measured.applied, pattern) << "the edges that were commanded";
  return plant.psi_s() - before;
}

struct Case {
  ThreePhase<> i;     ///< [A]
  ThreePhase<> sign;  ///< of the currents
};
constexpr std::array<Case, 4> cases{{{{20, -8, -12}, {1, -1, -1}},
                                     {{-20, 8, 12}, {-1, 1, 1}},
                                     {{9, 14, -23}, {1, 1, -1}},
                                     {{-9, 20, -11}, {-1, 1, -1}}}};
constexpr std::array<IntegratorKind, 4> integrators{IntegratorKind::fixed, IntegratorKind::exact,
                                                    IntegratorKind::cvode, IntegratorKind::erk};

TEST(DeadTime, AModulatedLegLosesTheLinkVoltageForOneDeadTimeInTheDirectionOfItsCurrent) {
  const GatePattern pattern = modulated(17'000, 12'000, 6'000);
  for (const IntegratorKind integrator : integrators) {
    for (const Case& c : cases) {
      SCOPED_TRACE(testing::Message() << "integrator " << int(integrator) << ", i_a " << c.i.a);
      const SpaceVector<> lost =
          flux_change(integrator, 0, c.i, pattern) - flux_change(integrator, dead_ns, c.i, pattern);
      const double volt_seconds = u_dc * dead_ns * 1e-9;
      const SpaceVector<> expected = volt_seconds * clarke(c.sign);
      // The other currents drop a little less at R_s: some R_s/σL_s of the period.
      EXPECT_NEAR(lost.alpha, expected.alpha, 3e-3 * volt_seconds);
      EXPECT_NEAR(lost.beta, expected.beta, 3e-3 * volt_seconds);
    }
  }
}

TEST(DeadTime, AnEdgeCostsByTheCurrentOfItsLeg) {
  const GatePattern rising = [] {
    GatePattern p{switch_states[0], 10'000};
    p.append({switch_states[1], 15'000});
    return p;
  }();
  const double volt_seconds = 2.0 / 3.0 * u_dc * dead_ns * 1e-9;  // of leg a, along α
  for (const IntegratorKind integrator : integrators) {
    for (const double i : {15.0, -15.0}) {
      const ThreePhase<> i_abc{i, -i / 2, -i / 2};
      const SpaceVector<> lost =
          flux_change(integrator, 0, i_abc, rising) - flux_change(integrator, dead_ns, i_abc, rising);
      EXPECT_NEAR(lost.alpha, i > 0 ? volt_seconds : 0.0, 3e-3 * volt_seconds);
      EXPECT_NEAR(lost.beta, 0.0, 3e-3 * volt_seconds);
    }
  }
}

// Without current and flux no diode conducts: the legs float, and nothing acts until a switch is on.
TEST(DeadTime, WithoutCurrentNothingActs) {
  const GatePattern zero_vectors = modulated(12'000, 12'000, 12'000);
  for (const IntegratorKind integrator : integrators) {
    const SpaceVector<> change = flux_change(integrator, dead_ns, {}, zero_vectors);
    EXPECT_EQ(magnitude(change), 0.0);
  }
}

std::vector<GateSegment> acted_by(DeadTime& dead_time, const GatePattern& pattern) {
  const ActedSegments acted = dead_time.step(pattern.segments());
  return {acted.segments().begin(), acted.segments().end()};
}

TEST(DeadTime, GoesOnBeyondTheEndOfAPeriod) {
  DeadTime dead_time{dead_ns};
  static_cast<void>(acted_by(dead_time, {switch_states[0], period_ns}));
  GatePattern late{switch_states[0], 24'000};
  late.append({switch_states[1], 1'000});
  EXPECT_EQ(acted_by(dead_time, late),
            (std::vector<GateSegment>{{{low, low, low}, 24'000}, {{off, low, low}, 1'000}}));
  EXPECT_EQ(acted_by(dead_time, {switch_states[1], period_ns}),
            (std::vector<GateSegment>{{{off, low, low}, 500}, {{high, low, low}, 24'500}}));
  EXPECT_EQ(acted_by(dead_time, {switch_states[2], period_ns}),
            (std::vector<GateSegment>{{{high, off, low}, 1'500}, {{high, high, low}, 23'500}}));
}

TEST(DeadTime, AShorterPulseTurnsNoSwitchOn) {
  DeadTime dead_time{dead_ns};
  static_cast<void>(acted_by(dead_time, {switch_states[0], period_ns}));
  GatePattern pulse{switch_states[0], 10'000};
  pulse.append({switch_states[1], 1'000});
  pulse.append({switch_states[0], 14'000});
  EXPECT_EQ(acted_by(dead_time, pulse),
            (std::vector<GateSegment>{
                {{low, low, low}, 10'000}, {{off, low, low}, 2'500}, {{low, low, low}, 12'500}}));
}

TEST(DeadTime, GatesThatHaveBeenOffTurnOnAtOnce) {
  DeadTime dead_time{dead_ns};
  EXPECT_EQ(acted_by(dead_time, {switch_states[1], period_ns}),
            (std::vector<GateSegment>{{switch_states[1], period_ns}}));
  GatePattern short_rest{gates_off, 1'000};
  short_rest.append({switch_states[4], 24'000});
  EXPECT_EQ(acted_by(dead_time, short_rest),
            (std::vector<GateSegment>{{gates_off, 1'500}, {switch_states[4], 23'500}}));
}

/// Sum of t_d over the changes of a leg is the longest for which it can be off; both switches are never on.
TEST(DeadTime, NoSwitchTurnsOnBeforeTheOtherOneHasBeenOffForTheDeadTime) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  const auto draw = [&random](int lowest, int highest) {
    return std::uniform_int_distribution{lowest, highest}(random);
  };
  DeadTime dead_time{dead_ns};
  std::array<LegState, 3> last_on{off, off, off};
  std::array<std::int64_t, 3> off_ns{dead_ns, dead_ns, dead_ns};
  for (int k = 0; k < 20'000; ++k) {
    GatePattern pattern;
    const int segments = draw(1, int(GatePattern::capacity));
    for (int n = 0; n < segments; ++n) {
      pattern.append({switch_states[std::size_t(draw(0, 7))], draw(1, 2 * dead_ns)});
    }
    std::int64_t duration_ns = 0;
    for (const auto& [state, ns] : acted_by(dead_time, pattern)) {
      duration_ns += ns;
      const std::array<LegState, 3> legs{state.a(), state.b(), state.c()};
      for (std::size_t x = 0; x < 3; ++x) {
        if (legs[x] == off) {
          off_ns[x] += ns;
          continue;
        }
        if (last_on[x] != off && legs[x] != last_on[x]) {
          ASSERT_GE(off_ns[x], dead_ns);
        }
        last_on[x] = legs[x];
        off_ns[x] = 0;
      }
    }
    ASSERT_EQ(duration_ns, pattern.duration_ns());
  }
}

TEST(DeadTime, AllIntegratorsMoveTheSamePlantAndItsEnergyBalances) {
  MechanicalLoad::Parameters load;
  load.load_torque = {.value = 2.0};
  std::vector<SpaceVector<>> fluxes;
  for (const IntegratorKind integrator : integrators) {
    SCOPED_TRACE(testing::Message() << "integrator " << int(integrator));
    MeteredPowerStage stage{stage_of(integrator, dead_ns), load};
    for (std::int64_t k = 0; k <= 800; ++k) {
      ASSERT_TRUE(stage.io().read(k * period_ns).plausible);
      const auto n = std::int32_t(k / 40 % 2);
      stage.io().write(k % 100 < 97 ? modulated(15'000 + 1'000 * n, 12'000 - 2'000 * n, 8'000)
                                    : GatePattern{gates_off, period_ns});
    }
    const MeteredPlant& plant = stage.io().plant();
    const auto energy = [&plant](int n) { return plant.state()[MeteredPlant::appended + n]; };
    using Meter = EnergyMeter<double>;
    const double drawn = energy(Meter::dc_link);
    const double spent = energy(Meter::stator_copper) + energy(Meter::rotor_copper) +
                         energy(Meter::mechanical) + plant.magnetic_energy();
    EXPECT_GT(drawn, 1.0);
    EXPECT_NEAR(drawn, spent, 1e-5 * drawn);
    fluxes.push_back(plant.psi_s());
  }
  EXPECT_GT(magnitude(fluxes[0]), 0.1);
  for (const SpaceVector<>& flux : fluxes) EXPECT_LT(magnitude(flux - fluxes[0]), 1e-5);
}

TEST(DeadTime, ShorterThanHalfOfThePeriod) {
  SimulatedDriveIoParameters p;
  p.period_ns = period_ns;
  p.dead_time_ns = period_ns / 2 - 1;
  EXPECT_EQ(p.validate(), nullptr);
  for (const std::int32_t wrong_ns : {-1, period_ns / 2, 2'000'000'000}) {
    p.dead_time_ns = wrong_ns;
    EXPECT_STREQ(p.validate(), "the dead time must be from zero to below half of the control period");
  }
}

}  // namespace
}  // namespace sextant
