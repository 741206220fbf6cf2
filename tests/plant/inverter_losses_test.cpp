// Losses of the inverter and temperatures of its junctions: closed forms of conduction loss for sinusoidal
// currents under a carrier, switching loss by counting, step responses of Foster networks.
#include "sextant/plant/inverter_losses.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double u_dc = 600;
constexpr auto upper_switch = std::size_t(LegDevice::upper_switch);
constexpr auto upper_diode = std::size_t(LegDevice::upper_diode);
constexpr auto lower_switch = std::size_t(LegDevice::lower_switch);
constexpr auto lower_diode = std::size_t(LegDevice::lower_diode);

/// A threshold and a slope. [V], [V/A]
LossPoints straight(double threshold, double slope) {
  return {{0, threshold}, {100, threshold + 100 * slope}};
}

/// A step of 1 ms of all legs in one state.
void hold(InverterLosses& losses, SwitchState state, ThreePhase<> i, double seconds = 1e-3) {
  losses.begin(u_dc);
  losses.add_segment(state, i, i, seconds);
  losses.end();
}

constexpr SwitchState all(LegState s) {
  return {s, s, s};
}

// rise(t) = Σ R_k (1 − e^(−t/τ_k)), whatever the steps.
TEST(FosterNetwork, StepResponseIsTheSumOfItsExponentials) {
  const FosterPairs pairs{{0.02, 1e-3}, {0.1, 1e-2}, {0.15, 5e-2}, {0.05, 0.3}};
  for (const double h : {25e-6, 1e-3, 0.04}) {
    FosterNetwork network{pairs};
    const int steps = int(std::lround(0.2 / h));
    for (int n = 0; n < steps; ++n) network.step(100, h);
    double rise = 0;
    for (const auto& [r, tau] : pairs) rise += 100 * r * (1 - std::exp(-0.2 / tau));
    EXPECT_NEAR(network.rise(), rise, 1e-11 * rise) << h;
  }
}

// scipy.integrate.solve_ivp, DOP853, rtol 1e-12, of τ_k x_k' = R_k P − x_k: 100 W for 10 ms, none for 30 ms,
// 40 W for 60 ms.
TEST(FosterNetwork, FollowsAChangingPowerAsScipyDoes) {
  FosterNetwork network{{{0.02, 1e-3}, {0.1, 1e-2}, {0.15, 5e-2}, {0.05, 0.3}}};
  network.step(100, 0.01);
  EXPECT_NEAR(network.rise(), 11.204072989846207, 1e-9);
  network.step(0, 0.01);
  network.step(0, 0.02);
  EXPECT_NEAR(network.rise(), 1.9552748694086617, 1e-9);
  network.step(40, 0.06);
  EXPECT_NEAR(network.rise(), 9.917126937721408, 1e-9);
}

TEST(FosterNetwork, BeginsInTheSteadyStateOfItsRise) {
  FosterNetwork network{{{0.1, 0.01}, {0.3, 2.0}}};
  network.begin(20);
  network.step(50, 0.5);  // 50 W · 0.4 K/W
  EXPECT_NEAR(network.rise(), 20, 1e-12);
}

/// Mean conduction loss of each device of leg a over one period of a sinusoidal current I cos(θ − φ), with
/// the leg high for the share (1 + m cos θ)/2 of each carrier period, in its middle. [W]
std::array<double, leg_devices> carrier_losses(InverterLosses& losses, double m, double phi, double current) {
  constexpr int carriers = 600;
  constexpr double seconds = 0.02 / carriers;
  std::array<double, leg_devices> joules{};
  for (int n = 0; n < carriers; ++n) {
    const auto i = [&](double share) -> ThreePhase<> {
      return {current * std::cos(2 * pi * (n + share) / carriers - phi), 0, 0};
    };
    const double duty = 0.5 * (1 + m * std::cos(2 * pi * (n + 0.5) / carriers));
    const double on = 0.5 * (1 - duty), off = 0.5 * (1 + duty);
    losses.begin(u_dc);
    losses.add_segment(all(LegState::low), i(0), i(on), on * seconds);
    losses.add_segment({LegState::high, LegState::low, LegState::low}, i(on), i(off), duty * seconds);
    losses.add_segment(all(LegState::low), i(off), i(1), on * seconds);
    losses.end();
    for (std::size_t d = 0; d < leg_devices; ++d) joules[d] += losses.heat()[d];
  }
  for (double& x : joules) x /= 0.02;
  return joules;
}

// P = (1/2π ± m cos φ/8) V I + (1/8 ± m cos φ/3π) r I², + of a switch, − of a diode. Source: D. Graovac,
// M. Pürschel, "IGBT power losses calculation using the data-sheet parameters", Infineon, 2009.
TEST(InverterLosses, ConductionOfASinusoidalCurrentIsThatOfTheClosedForm) {
  InverterLossParameters p;
  p.switch_voltage.cold = straight(0.9, 0.011);
  p.diode_voltage.cold = straight(1.1, 0.007);
  for (const double m : {0.0, 0.5, 0.95}) {
    for (const double phi : {0.0, 0.7, 2.6}) {
      InverterLosses losses{p, {}};
      const auto found = carrier_losses(losses, m, phi, 80);
      const auto closed = [&](double v, double r, double sign) {
        const double mc = sign * m * std::cos(phi);
        return (1 / (2 * pi) + mc / 8) * v * 80 + (1.0 / 8 + mc / (3 * pi)) * r * 80 * 80;
      };
      for (const std::size_t d : {upper_switch, lower_switch})
        EXPECT_NEAR(found[d], closed(0.9, 0.011, 1), 2e-4 * 50) << m << ' ' << phi;
      for (const std::size_t d : {upper_diode, lower_diode})
        EXPECT_NEAR(found[d], closed(1.1, 0.007, -1), 2e-4 * 50) << m << ' ' << phi;
    }
  }
}

// Energies that are straight lines through zero, each carrier period with one turn-on and one turn-off in one
// half wave of the current: the mean over it is I/π.
TEST(InverterLosses, SwitchingOfASinusoidalCurrentIsThatOfCounting) {
  InverterLossParameters p;
  p.turn_on.cold = straight(0, 60e-6);
  p.turn_off.cold = straight(0, 50e-6);
  p.recovery.cold = straight(0, 30e-6);
  InverterLosses losses{p, {}};
  const auto found = carrier_losses(losses, 0.8, 0.4, 80);
  const double per_second = 600 / 0.02 * 80 / pi;
  for (const std::size_t d : {upper_switch, lower_switch})
    EXPECT_NEAR(found[d], 110e-6 * per_second, 2e-3 * found[d]);
  for (const std::size_t d : {upper_diode, lower_diode})
    EXPECT_NEAR(found[d], 30e-6 * per_second, 2e-3 * found[d]);
}

// Positive current through low, off, high, off, low: the lower diode keeps it while the leg is off.
TEST(InverterLosses, ADeadTimeMovesTheLossAndAddsNone) {
  InverterLossParameters p;
  p.turn_on.cold = {{0, 2}, {100, 2}};
  p.turn_off.cold = {{0, 3}, {100, 3}};
  p.recovery.cold = {{0, 5}, {100, 5}};
  InverterLosses losses{p, {}};
  const ThreePhase<> i{40, -40, 0};
  hold(losses, all(LegState::low), i);
  const double begin = losses.energies().lost;
  hold(losses, all(LegState::off), i);
  EXPECT_EQ(losses.heat()[upper_switch], 0);
  // Negative current leaves the lower switch of leg b for its upper diode; leg c has none.
  EXPECT_EQ(losses.heat()[leg_devices + lower_switch], 3 * std::pow(u_dc / 600, 1.3));
  hold(losses, all(LegState::high), i);
  EXPECT_EQ(losses.heat()[upper_switch], 2);
  EXPECT_EQ(losses.heat()[lower_diode], 5);
  hold(losses, all(LegState::off), i);
  EXPECT_EQ(losses.heat()[upper_switch], 3);
  // Leg b's current passes from its upper diode, which it had in the off state too, to the lower switch.
  hold(losses, all(LegState::low), i);
  EXPECT_EQ(losses.heat()[leg_devices + upper_diode], 5);
  EXPECT_EQ(losses.heat()[leg_devices + lower_switch], 2);
  EXPECT_EQ(losses.energies().lost - begin, 3 + 7 + 3 + 7);
}

TEST(InverterLosses, EnergiesFollowVoltageAndTemperature) {
  InverterLossParameters p;
  p.turn_on = {{{0, 0}, {100, 10e-3}}, {{0, 0}, {100, 16e-3}}};
  p.energy_voltage = 300;
  p.ambient = 75;  // half way
  InverterLosses losses{p, {}};
  hold(losses, all(LegState::low), {50, 0, 0});
  hold(losses, all(LegState::high), {50, 0, 0});
  EXPECT_NEAR(losses.heat()[upper_switch], 6.5e-3 * std::pow(2, 1.3), 1e-12);
}

// A table of three points with a knee: between them and beyond the last one.
TEST(InverterLosses, ACurveRunsInLinesBetweenItsPoints) {
  const LossCurve curve{{{0, 1}, {10, 2}, {30, 3}}, {}};
  EXPECT_DOUBLE_EQ(curve(-5, 0), 1.5);
  EXPECT_DOUBLE_EQ(curve(20, 0), 2.5);
  EXPECT_DOUBLE_EQ(curve(50, 0), 4);
  const LossCurve falling{{{0, 2}, {10, 1}}, {}};
  EXPECT_EQ(falling(100, 0), 0);
}

// Constant current and state: ϑ = ambient + R_case ΣP + R_j P, and each junction on its own exponential.
TEST(InverterLosses, JunctionsReachTheirSteadyState) {
  InverterLossParameters p;
  p.switch_voltage.cold = straight(1, 0.01);
  p.diode_voltage.cold = straight(1.2, 0.005);
  p.switch_network = {{0.1, 0.01}, {0.2, 0.05}};
  p.diode_network = {{0.5, 0.02}};
  p.case_network = {{0.05, 1.0}};
  p.ambient = 35;
  InverterLosses losses{p, {}};
  const double of_switch = (1 + 0.5) * 50, of_diode = (1.2 + 0.125) * 25;
  const double total = of_switch + 2 * of_diode;
  const SwitchState state{LegState::high, LegState::high, LegState::high};
  hold(losses, state, {50, -25, -25}, 0.03);
  EXPECT_NEAR(losses.case_temperature(), 35 + 0.05 * total * (1 - std::exp(-0.03)), 1e-9);
  EXPECT_NEAR(losses.junction_temperatures()[upper_switch] - losses.case_temperature(),
              of_switch * (0.1 * (1 - std::exp(-3)) + 0.2 * (1 - std::exp(-0.6))), 1e-9);
  for (int n = 0; n < 100; ++n) hold(losses, state, {50, -25, -25}, 0.5);
  EXPECT_NEAR(losses.case_temperature(), 35 + 0.05 * total, 1e-9);
  EXPECT_NEAR(losses.junction_temperatures()[upper_switch], 35 + 0.05 * total + 0.3 * of_switch, 1e-9);
  EXPECT_NEAR(losses.junction_temperatures()[leg_devices + upper_diode], 35 + 0.05 * total + 0.5 * of_diode,
              1e-9);
  EXPECT_NEAR(losses.junction_temperatures()[lower_switch], losses.case_temperature(), 1e-12);
  EXPECT_EQ(losses.hottest_junction(), losses.junction_temperatures()[upper_switch]);
  EXPECT_NEAR(losses.power(), total, 1e-9);
}

// What the plant's drops take is not drawn from the link once more.
TEST(InverterLosses, DrawsWhatTheDropsLeaveOver) {
  InverterLossParameters p;
  p.switch_voltage.cold = straight(1, 0.02);
  InverterLosses losses{p, {0.7, 0.005}};
  // Leg a alone conducts by a switch: 50 A · 2 V; the drops count all currents, 0.7 Σ|i| + 0.005 Σi².
  hold(losses, {LegState::high, LegState::high, LegState::high}, {50, -25, -25}, 0.01);
  const double drawn = 100 - 0.7 * 100 - 0.005 * (2500 + 2 * 625);
  EXPECT_NEAR(losses.drawn_power(), drawn, 1e-9);
  EXPECT_EQ(losses.energies().drawn, 0) << "over the next reading";
  hold(losses, {LegState::high, LegState::high, LegState::high}, {0, 0, 0}, 0.04);
  EXPECT_NEAR(losses.energies().drawn, 0.04 * drawn, 1e-12);
  EXPECT_NEAR(losses.energies().lost, 1, 1e-12);
}

TEST(InverterLosses, ACurrentThatChangesItsSignLeavesTheSwitchForTheDiode) {
  InverterLossParameters p;
  p.switch_voltage.cold = {{0, 2}, {100, 2}};
  p.diode_voltage.cold = {{0, 3}, {100, 3}};
  InverterLosses losses{p, {}};
  losses.begin(u_dc);
  losses.add_segment(all(LegState::high), {30, 0, 0}, {-10, 0, 0}, 0.4);
  losses.end();
  EXPECT_NEAR(losses.heat()[upper_switch], 2 * 15 * 0.3, 1e-12);
  EXPECT_NEAR(losses.heat()[upper_diode], 3 * 5 * 0.1, 1e-12);
}

TEST(InverterLossParameters, RefusesWhatMakesNoCurveOrNetwork) {
  EXPECT_EQ(InverterLossParameters{}.validate(), nullptr);
  const auto with = [](auto change) {
    InverterLossParameters p;
    p.switch_voltage.cold = straight(1, 0.01);
    change(p);
    return p.validate();
  };
  EXPECT_EQ(with([](auto&) {}), nullptr);
  EXPECT_NE(with([](auto& p) { p.turn_on.cold = {{10, 1}}; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.turn_on.cold = {{10, 1}, {10, 2}}; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.turn_on.cold = {{0, 1}, {10, -2}}; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.turn_on.hot = {{0, 1}, {10, 2}}; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.hot = p.cold; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.switch_network = {{0.1, 0}}; }), nullptr);
  EXPECT_NE(with([](auto& p) { p.switch_network.assign(5, {0.1, 0.1}); }), nullptr);
  EXPECT_NE(with([](auto& p) { p.start_case = 60; }), nullptr);
  InverterLossParameters without;
  without.ambient = 30;
  EXPECT_NE(without.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
