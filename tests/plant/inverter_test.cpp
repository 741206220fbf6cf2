#include "sextant/plant/inverter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double u_dc = 530.0;
constexpr auto low = LegState::low;
constexpr auto high = LegState::high;
constexpr auto off = LegState::off;

SpaceVector<double> current(double a, double b) {
  return clarke(ThreePhase<double>{a, b, -a - b});
}

TEST(Inverter, DrivenLegsGiveTheIdealVoltageWhateverTheCurrent) {
  for (const SwitchState state : switch_states) {
    Inverter<double> inverter;
    const SpaceVector<double> e{100, 200};
    inverter.set(state, u_dc, current(30, -50), e);
    EXPECT_TRUE(inverter.voltage_is_fixed());
    EXPECT_FALSE(inverter.has_events());
    EXPECT_EQ(inverter.voltage_map()(e), stator_voltage(state, u_dc));
    EXPECT_EQ(inverter.events(current(30, -50), e), (std::array<double, 3>{1, 1, 1}));
    EXPECT_EQ(inverter.dc_link_current(current(30, -50)),
              dc_link_current(state, inverse_clarke(current(30, -50))));
  }
}

TEST(Inverter, OffLegConductsThroughTheDiodeOfItsCurrent) {
  Inverter<double> inverter;
  inverter.set({off, off, off}, u_dc, current(10, -4), {});
  EXPECT_EQ(inverter.ties(), (LegTies{LegTie::low, LegTie::high, LegTie::high}));
  // The voltage opposes the current: power flows back into the link.
  EXPECT_LT(dot(inverter.voltage_map()({}), current(10, -4)), 0.0);
  EXPECT_DOUBLE_EQ(inverter.dc_link_current(current(10, -4)), -10.0);
}

TEST(Inverter, BlockedLegKeepsItsCurrentConstant) {
  Inverter<double> inverter;
  const SpaceVector<double> e{40, -25};
  inverter.set({low, off, high}, u_dc, current(7, 0), e);
  ASSERT_EQ(inverter.ties(), (LegTies{LegTie::low, LegTie::floating, LegTie::high}));
  const SpaceVector<double> u = inverter.voltage_map()(e);
  EXPECT_NEAR(dot(phase_axes<double>[1], u), dot(phase_axes<double>[1], e), 1e-12);
  const std::array<double, 3> v = inverter.leg_potentials(e);
  EXPECT_NEAR(v[0], 0.0, 1e-9);
  EXPECT_NEAR(v[2], u_dc, 1e-9);
  // v_x = 3/2 d_x·u_s + (v_y + v_z)/2
  EXPECT_NEAR(v[1], 1.5 * dot(phase_axes<double>[1], u) + u_dc / 2, 1e-9);
}

TEST(Inverter, BlockedLegThatWouldLeaveTheLinkConducts) {
  Inverter<double> inverter;
  // One driven leg low, EMF pulls leg b below the negative rail: its lower diode conducts.
  inverter.set({low, off, off}, u_dc, {},
               inverse_clarke(SpaceVector<double>{}).a * SpaceVector<double>{1, 0});
  EXPECT_EQ(floating_legs(inverter.ties()), 2);
  const SpaceVector<double> e = clarke(ThreePhase<double>{50, -30, -20});
  inverter.set({low, off, off}, u_dc, {}, e);
  EXPECT_EQ(inverter.ties()[1], LegTie::low);
}

TEST(Inverter, RectifiesOnlyAboveTheLink) {
  Inverter<double> inverter;
  const SpaceVector<double> below = clarke(ThreePhase<double>{264, -264, 0});
  inverter.set(gates_off, u_dc, {}, below);
  EXPECT_EQ(floating_legs(inverter.ties()), 3);
  EXPECT_NEAR(inverter.events({}, below)[0], 2.0, 0.01);
  const SpaceVector<double> above = clarke(ThreePhase<double>{266, -266, 0});
  EXPECT_LT(inverter.events({}, above)[0], 0.0);
  inverter.on_event(0, {}, above);
  EXPECT_EQ(inverter.ties(), (LegTies{LegTie::high, LegTie::low, LegTie::floating}));
}

TEST(Inverter, CurrentOfABlockedLegIsProjectedToZero) {
  Inverter<double> inverter;
  inverter.set({low, high, off}, u_dc, current(-5, 5), {});
  const ThreePhase<double> i = inverse_clarke(inverter.admissible_current(current(-5, 5.00005)));
  EXPECT_NEAR(i.c, 0.0, 1e-12);
  EXPECT_NEAR(i.b - i.a, 10.00005, 1e-12);
}

// What a tolerance has left of a current may flow against the device that takes over: the next event would be
// due at once, and so for ever.
TEST(Inverter, NoEventIsDueWhereALegHasTakenOver) {
  constexpr unsigned seed = 20261126;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 generator{seed};
  std::uniform_real_distribution<double> share{-1.0, 1.0};
  std::uniform_int_distribution<int> leg{0, 2};
  int taken_over = 0;
  for (int draw = 0; draw < 20'000; ++draw) {
    const double threshold = draw % 2 == 0 ? 0.0 : 1.2;
    Inverter<double> inverter{threshold};
    std::array<LegState, 3> states{};
    for (LegState& state : states) state = std::array{low, high, off}[std::size_t(leg(generator))];
    const double residue = 2e-4 * share(generator);
    const double flows = 20 * share(generator);
    std::array<double, 3> i{};
    const auto x = std::size_t(leg(generator));
    i[x] = residue;
    i[(x + 1) % 3] = flows;
    i[(x + 2) % 3] = -flows - residue;
    const SpaceVector<double> i_s = clarke(ThreePhase<double>{i[0], i[1], i[2]});
    const SpaceVector<double> e{400 * share(generator), 400 * share(generator)};
    inverter.set({states[0], states[1], states[2]}, u_dc, i_s, e);
    const std::array<double, 3> g = inverter.events(inverter.admissible_current(i_s), e);
    EXPECT_GT(*std::min_element(g.begin(), g.end()), 0.0) << "draw " << draw;
    taken_over += inverter.has_idle_legs() && inverter.ties()[x] != LegTie::floating ? 1 : 0;
  }
  EXPECT_GT(taken_over, 1000);
}

// In every topology: power balances at the terminals, no leg leaves the link, no event is pending.
TEST(Inverter, EveryTopologyIsConsistent) {
  constexpr unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> amps{-20, 20};
  std::uniform_real_distribution<double> volts{-400, 400};
  for (int n = 0; n < 20000; ++n) {
    SCOPED_TRACE(n);
    const auto leg = [&] { return LegState(random() % 3U); };
    const SwitchState state{leg(), leg(), leg()};
    SpaceVector<double> i = current(amps(random), amps(random));
    switch (random() % 4U) {
      case 0:
        i = {};
        break;
      case 1:
        i = current(0, i.alpha);
        break;
      default:
        break;
    }
    const SpaceVector<double> e{volts(random), volts(random)};
    Inverter<double> inverter;
    inverter.set(state, u_dc, i, e);
    i = inverter.admissible_current(i);
    const SpaceVector<double> u = inverter.voltage_map()(e);
    EXPECT_NEAR(1.5 * dot(u, i), u_dc * inverter.dc_link_current(i), 1e-9);
    const std::array<double, 3> g = inverter.events(i, e);
    EXPECT_GE(*std::min_element(g.begin(), g.end()), 0.0);
    if (floating_legs(inverter.ties()) < 3) {
      for (const double v : inverter.leg_potentials(e)) {
        EXPECT_GE(v, -2 * Inverter<double>::voltage_tolerance);
        EXPECT_LE(v, u_dc + 2 * Inverter<double>::voltage_tolerance);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
