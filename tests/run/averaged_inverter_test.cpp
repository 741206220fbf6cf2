// The averaged law of the simulated inverter: its duties against the closed form of dead time, its currents
// against the harmonics that a dead time makes in a machine, and its mean torque against that of the switched
// law.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "run/drive_rig.hpp"
#include "sextant/control/field_oriented_controller.hpp"
#include "sextant/plant/mean_duties.hpp"
#include "sextant/power_stage/dead_time.hpp"

namespace sextant {
namespace {

constexpr double u_dc = 530.0;
constexpr std::int32_t dead_ns = 3'000;
constexpr std::int32_t period_ns = 125'000;

/// Legs that are high in the middle of the period, for these shares of it.
GatePattern modulated(const std::array<double, 3>& shares) {
  std::array<std::int32_t, 3> begin_ns{};  // until then low, and as long at the end
  for (std::size_t x = 0; x < 3; ++x) begin_ns[x] = std::int32_t((1 - shares[x]) / 2 * period_ns);
  std::vector<std::int32_t> edges{0, period_ns};
  for (const std::int32_t t : begin_ns) edges.insert(edges.end(), {t, period_ns - t});
  std::ranges::sort(edges);
  GatePattern pattern;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    const auto leg = [&](std::size_t x) {
      const bool is_high = edges[k] >= begin_ns[x] && edges[k] < period_ns - begin_ns[x];
      return is_high ? LegState::high : LegState::low;
    };
    pattern.append({{leg(0), leg(1), leg(2)}, edges[k + 1] - edges[k]});
  }
  return pattern;
}

TEST(AveragedInverter, ADeadTimeTakesItsShareOfThePeriodInTheDirectionOfTheCurrent) {
  const std::array<double, 3> shares{0.7, 0.4, 0.2};
  for (const ThreePhase<> i : {ThreePhase<>{9, -4, -5}, {-9, 13, -4}, {6, -6, 0}}) {
    DeadTime dead_time{dead_ns};
    static_cast<void>(dead_time.step(GatePattern{switch_states[0], period_ns}.segments()));
    const ThreePhase<> found = mean_duties(dead_time.step(modulated(shares).segments()).segments(), i);
    const auto sign = [](double x) { return double(x > 0) - double(x < 0); };
    const double lost = double(dead_ns) / period_ns;
    EXPECT_NEAR(found.a, shares[0] - lost * sign(i.a), 1e-5);
    EXPECT_NEAR(found.b, shares[1] - lost * sign(i.b), 1e-5);
    EXPECT_NEAR(found.c, shares[2] - lost * sign(i.c), 1e-5);
  }
}

SimulatedPowerStage::Parameters stage_of(InverterLaw law, std::int32_t dead_time_ns = dead_ns) {
  SimulatedPowerStage::Parameters p;
  p.integrator = IntegratorKind::fixed;
  p.io.u_dc = u_dc;
  p.io.period_ns = period_ns;
  p.io.law = law;
  p.io.dead_time_ns = dead_time_ns;
  return p;
}

/// A machine without load at synchronous speed behind legs that are modulated by sines.
constexpr double frequency_hz = 20.0;

/// Harmonic n of i_a in the steady state, n below zero turning backwards: the Fourier coefficient of the
/// current vector over the last ten turns. [A]
std::complex<double> harmonic(InverterLaw law, int order) {
  constexpr int per_turn = 400;  // periods
  constexpr int turns = 20;
  const double omega_e = 2 * std::numbers::pi * frequency_hz;
  const SimulatedPowerStage::Parameters p = stage_of(law);
  SimulatedPowerStage stage{p, {.imposed_speed = ProfileParameters{.value = omega_e / 2}}};
  std::complex<double> sum{};
  for (int k = 0; k < turns * per_turn; ++k) {
    const double angle = 2 * std::numbers::pi * k / per_turn;
    const Measurement<> m = stage.io().read(std::int64_t{k} * period_ns);
    if (k >= turns / 2 * per_turn) {
      const SpaceVector<> i = clarke(m.i_abc);
      sum += std::complex{i.alpha, i.beta} * std::polar(1.0, -order * angle);
    }
    std::array<double, 3> shares{};
    for (std::size_t x = 0; x < 3; ++x)
      shares[x] = 0.5 + 0.4 * std::cos(angle - 2 * std::numbers::pi / 3 * double(x));
    stage.io().write(modulated(shares));
  }
  return sum / double(turns / 2 * per_turn);
}

// A leg loses u_dc t_d/T sign(i_x): a square wave of the phase, whose harmonics 5 and 7
// make vectors that turn backwards and forwards. The machine has the impedance of its T circuit to them.
TEST(AveragedInverter, ItsCurrentsHaveTheHarmonicsThatDeadTimesMake) {
  const InductionMachineParameters<> m = SimulatedPowerStage::Parameters{}.plant.machine;
  const double omega_e = 2 * std::numbers::pi * frequency_hz;
  for (const int order : {-5, 7}) {
    SCOPED_TRACE(testing::Message() << "harmonic " << order);
    const double turning = order * omega_e;
    const std::complex<double> j{0, 1};
    const std::complex<double> rotor = m.r_r * turning / (turning - omega_e) + j * turning * m.l_lr;
    const std::complex<double> main = j * turning * m.l_m;
    const std::complex<double> impedance = m.r_s + j * turning * m.l_ls + rotor * main / (rotor + main);
    const double voltage = 4 / std::numbers::pi * u_dc * dead_ns / period_ns / std::abs(order);
    const double expected = voltage / std::abs(impedance);
    EXPECT_NEAR(std::abs(harmonic(InverterLaw::averaged, order)), expected, 0.01 * expected);
    EXPECT_NEAR(std::abs(harmonic(InverterLaw::switched, order)), expected, 0.03 * expected);
  }
}

/// Mean torque of the whole drive, which knows its inverter. [N·m]
double mean_torque(InverterLaw law, double omega_m, double torque) {
  const InverterModel<>::Parameters inverter{
      .dead_time_ns = 1'500, .threshold_voltage = 1.2, .slope_resistance = 0.02};
  RigParameters p = RigParameters::at_speed(omega_m);
  p.stage.io.law = law;
  p.stage.io.dead_time_ns = inverter.dead_time_ns;
  p.stage.plant.drops = {.threshold_voltage = inverter.threshold_voltage,
                         .slope_resistance = inverter.slope_resistance};
  p.controller.flux_estimator = FluxEstimatorKind::hybrid;
  p.controller.inverter = inverter;
  p.drive.magnetise_first = true;
  p.drive.protection.inverter = inverter;
  p.drive.torque_monitor.inverter = inverter;
  FieldOrientedController<double>::Parameters method;
  static_cast<EstimatingController<double>::Parameters&>(method) = p.controller;
  DriveRigOf<FieldOrientedController<double>> rig{p, method};
  rig.start();
  rig.run(0.3);
  rig.torque = torque;
  rig.run(0.2);
  const double mean = rig.watch(0.1).mean_torque;
  EXPECT_FALSE(rig.telemetry.latched.any());
  return mean;
}

TEST(AveragedInverter, ItsMeanTorqueIsThatOfTheSwitchedLaw) {
  for (const double omega_m : {-150.0, 0.0, 20.0, 100.0}) {
    for (const double torque : {-60.0, 15.0}) {
      const double averaged = mean_torque(InverterLaw::averaged, omega_m, torque);
      const double switched = mean_torque(InverterLaw::switched, omega_m, torque);
      EXPECT_NEAR(averaged, switched, 0.2) << omega_m << " rad/s, " << torque << " N·m";
    }
  }
}

// Without dead time and drops the flux at the end of a period is that of the edges, but for what the
// resistance takes of the ripple.
TEST(AveragedInverter, AnIdealInverterMovesTheFluxAsItsEdgesDo) {
  std::array<SpaceVector<>, 2> fluxes{};
  for (const InverterLaw law : {InverterLaw::switched, InverterLaw::averaged}) {
    const SimulatedPowerStage::Parameters p = stage_of(law, 0);
    SimulatedPowerStage stage{p, {.imposed_speed = ProfileParameters{.value = 50.0}}};
    for (int k = 0; k < 40; ++k) {
      static_cast<void>(stage.io().read(std::int64_t{k} * period_ns));
      stage.io().write(modulated({0.7, 0.4, 0.3}));
    }
    EXPECT_EQ(stage.io().averaged().empty(), law == InverterLaw::switched);
    fluxes[std::size_t(law)] = stage.io().plant().psi_s();
  }
  EXPECT_NEAR(magnitude(fluxes[0] - fluxes[1]), 0.0, 1e-4 * magnitude(fluxes[0]));
}

// Legs that are off do what their diodes do, edge by edge.
TEST(AveragedInverter, GatesOffAreNotAveraged) {
  const SimulatedPowerStage::Parameters p = stage_of(InverterLaw::averaged);
  SimulatedPowerStage stage{p, {.imposed_speed = ProfileParameters{.value = 0.0}}};
  static_cast<void>(stage.io().read(0));
  stage.io().write(modulated({0.9, 0.4, 0.3}));
  static_cast<void>(stage.io().read(period_ns));
  EXPECT_GT(magnitude(stage.io().plant().i_s()), 1.0);
  stage.io().write({gates_off, period_ns});
  static_cast<void>(stage.io().read(3 * period_ns));
  EXPECT_TRUE(stage.io().averaged().empty());
  EXPECT_LT(magnitude(stage.io().plant().i_s()), 1e-3);
}

}  // namespace
}  // namespace sextant
