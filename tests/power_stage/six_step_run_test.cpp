// The plant under six-step operation by the modulator, against the harmonic circuit of the machine.

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/control/space_vector_modulator.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"

namespace sextant {
namespace {

using Complex = std::complex<double>;
constexpr Complex j{0, 1};
constexpr double u_dc = 530;
constexpr std::int32_t period_ns = 25'000;
constexpr int periods_a_turn = 240;
constexpr double omega_e = 2 * std::numbers::pi / (periods_a_turn * period_ns * 1e-9);  // [rad/s]

/// Voltage, current and stator flux of one order of six-step operation in the T circuit, at the slip of that
/// order: the rotor turns with omega_r, the order with h·omega_e.
struct Order {
  double h{};
  Complex u{};
  Complex i{};
  Complex psi{};

  Order(int order, const InductionMachineParameters<>& m, double omega_r) : h{double(order)} {
    const double slip = (h * omega_e - omega_r) / (h * omega_e);
    const Complex magnetising = j * h * omega_e * m.l_m;
    const Complex rotor = m.r_r / slip + j * h * omega_e * m.l_lr;
    const Complex stator = m.r_s + j * h * omega_e * m.l_ls;
    u = 4 / std::numbers::pi * u_dc * std::sin(h * std::numbers::pi / 6) / h;
    i = u / (stator + magnetising * rotor / (magnetising + rotor));
    psi = (u - m.r_s * i) / (j * h * omega_e);
  }
};

/// Orders 1, −5, 7, −11, 13 … of six-step operation.
std::vector<Order> six_step_orders(const InductionMachineParameters<>& m, double omega_r) {
  std::vector<Order> orders;
  for (int n = -20; n <= 20; ++n) orders.emplace_back(6 * n + 1, m, omega_r);
  return orders;
}

/// Current of an order as samples at the beginning of every period have it, with the orders that these
/// samples do not tell from it. [A]
Complex sampled_current(int h, const InductionMachineParameters<>& m, double omega_r) {
  Complex sum{};
  for (int n = -20; n <= 20; ++n) sum += Order{h + n * periods_a_turn, m, omega_r}.i;
  return sum;
}

/// One turn of the plant in steady state, at the beginning of every period.
struct Turn {
  std::vector<Complex> current;  ///< [A]
  std::vector<double> torque;    ///< [N·m]
};

/// The modulator's demand turns with omega_e from the angle 0 on, in the middle of the first period.
Turn turn_of(const InductionMachineParameters<>& machine, double omega_m, double demand) {
  SimulatedPowerStage::Parameters stage{.integrator = IntegratorKind::exact};
  stage.plant.machine = machine;
  MechanicalLoad::Parameters load{};
  load.imposed_speed = ProfileParameters{.value = omega_m};
  SimulatedPowerStage power{stage, load};
  const SpaceVectorModulator<double>::Parameters p{.overmodulation = Overmodulation::fundamental};
  SpaceVectorModulator<double> modulator{p};
  Turn turn;
  constexpr int turns = 200;
  for (int k = 0; k < turns * periods_a_turn; ++k) {
    (void)power.io().read(std::int64_t(k) * period_ns);
    if (k >= (turns - 1) * periods_a_turn) {
      turn.current.emplace_back(power.io().plant().i_s().alpha, power.io().plant().i_s().beta);
      turn.torque.push_back(power.io().plant().tau_e());
    }
    const double theta = 2 * std::numbers::pi * (k + 0.5) / periods_a_turn;
    const SpaceVector<double> u =
        modulator.mean_voltage({demand * std::cos(theta), demand * std::sin(theta)}, u_dc);
    power.io().write(modulator.step(u, u_dc, period_ns));
  }
  return turn;
}

/// Coefficient of an order in the samples of one turn.
template <class Sample>
Complex coefficient(const std::vector<Sample>& samples, double order) {
  Complex sum{};
  for (std::size_t k = 0; k < samples.size(); ++k) {
    sum += samples[k] * std::exp(-j * order * (2 * std::numbers::pi * double(k) / periods_a_turn));
  }
  return sum / double(samples.size());
}

TEST(SixStepRun, EveryOrderOfTheCurrentIsThatOfTheHarmonicCircuit) {
  const InductionMachineParameters<> machine{};
  for (const double slip : {-0.03, 0.04}) {
    const double omega_r = (1 - slip) * omega_e;
    const Turn turn = turn_of(machine, omega_r / machine.pole_pairs, 2 / std::numbers::pi * u_dc);
    for (const int h : {1, -5, 7, -11, 13, -17, 19}) {
      const Complex circuit = sampled_current(h, machine, omega_r);
      EXPECT_LT(std::abs(coefficient(turn.current, h) - circuit), 5e-4 * std::abs(circuit) + 5e-4) << h;
    }
  }
}

TEST(SixStepRun, TheTorqueRipplesWithSixTimesTheFrequencyAsTheHarmonicsMakeIt) {
  const InductionMachineParameters<> machine{};
  const double omega_r = 0.96 * omega_e;
  const Turn turn = turn_of(machine, omega_r / machine.pole_pairs, 2 / std::numbers::pi * u_dc);
  const std::vector<Order> orders = six_step_orders(machine, omega_r);
  std::vector<double> torque;
  for (int k = 0; k < periods_a_turn; ++k) {
    Complex i{};
    Complex psi{};
    for (const Order& o : orders) {
      const Complex turned = std::exp(j * o.h * (2 * std::numbers::pi * k / periods_a_turn));
      i += o.i * turned;
      psi += o.psi * turned;
    }
    torque.push_back(1.5 * machine.pole_pairs * std::imag(std::conj(psi) * i));
  }
  const auto ripple = [](const std::vector<double>& t) {
    const auto [least, most] = std::minmax_element(t.begin(), t.end());
    return *most - *least;
  };
  EXPECT_NEAR(coefficient(turn.torque, 0).real(), coefficient(torque, 0).real(), 0.05);
  EXPECT_LT(std::abs(coefficient(turn.torque, 6) - coefficient(torque, 6)), 0.05);
  EXPECT_GT(ripple(torque), 2);
  EXPECT_NEAR(ripple(turn.torque), ripple(torque), 0.02 * ripple(torque));
}

// Between the courses too the machine's fundamental is that of the circuit at the voltage demanded.
TEST(SixStepRun, TheFundamentalOfTheCurrentFollowsTheDemand) {
  const InductionMachineParameters<> machine{};
  const double omega_r = 0.96 * omega_e;
  for (const double share : {0.9, 1.01, 1.03, 1.06, 1.09}) {
    const double demand = share * u_dc / std::numbers::sqrt3;
    const Turn turn = turn_of(machine, omega_r / machine.pole_pairs, demand);
    const Order six_step{1, machine, omega_r};
    const Complex expected = demand / six_step.u * six_step.i;
    EXPECT_LT(std::abs(coefficient(turn.current, 1) - expected), 2e-3 * std::abs(expected)) << share;
  }
}

}  // namespace
}  // namespace sextant
