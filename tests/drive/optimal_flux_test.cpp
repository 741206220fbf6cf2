#include "sextant/drive/optimal_flux.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240907;
constexpr double no_iron_loss = std::numeric_limits<double>::infinity();

/// The T-equivalent circuit at a stator flux and a slip frequency, from its two mesh equations.
struct Circuit {
  double torque;   ///< [N·m]
  double current;  ///< |i_s| [A]
  double voltage;  ///< |u_s| [V]
  double loss;     ///< in stator, rotor and iron [W]

  Circuit(const InductionMachineParameters<>& m, double r_fe, double psi, double omega_r, double omega_slip) {
    using Complex = std::complex<double>;
    const Complex j{0.0, 1.0};
    // 0 = R_r i_r + j ω_slip (L_r i_r + L_m i_s) gives i_r by i_s, and ψ = L_s i_s + L_m i_r the rest.
    const Complex i_r_by_i_s = -j * omega_slip * m.l_m / (m.r_r + j * omega_slip * m.l_r());
    const Complex i_s = psi / (m.l_s() + m.l_m * i_r_by_i_s);
    const double omega_s = omega_r + omega_slip;
    torque = 1.5 * m.pole_pairs * psi * i_s.imag();
    current = std::abs(i_s);
    voltage = std::abs(m.r_s * i_s + j * omega_s * psi);
    const double u_iron = omega_s * psi;
    loss = 1.5 * (m.r_s * std::norm(i_s) + m.r_r * std::norm(i_r_by_i_s * i_s) + u_iron * u_iron / r_fe);
  }
};

/// Slip frequency of the breakdown torque, L_s R_r/(σ L_s L_r). [rad/s]
double breakdown_slip(const InductionMachineParameters<>& m) {
  return m.l_s() * m.r_r / (m.sigma_l_s() * m.l_r());
}

/// A machine on a link, with the limits of its drive.
struct Case {
  InductionMachineParameters<> machine{};
  double psi{1.1};
  double u_dc{530};
  double torque{150};
  double current{160};
  double r_fe{no_iron_loss};
  double least_share{0.05};
  double breakdown_use{0.95};

  [[nodiscard]] TorqueCapability<>::Parameters limits() const {
    return {.machine = machine,
            .flux_reference = psi,
            .breakdown_use = breakdown_use,
            .current_limit = current,
            .torque = torque};
  }
  /// The circuit that makes the torque at a flux, on the stable side; none where it is beyond the breakdown.
  [[nodiscard]] std::optional<Circuit> at(double flux, double omega_m, double wanted) const {
    const double sign = wanted < 0.0 ? -1.0 : 1.0;
    double below = 0.0;
    double above = breakdown_slip(machine);
    const auto of = [&](double slip) {
      return Circuit{machine, r_fe, flux, machine.pole_pairs * omega_m, sign * slip};
    };
    if (std::abs(of(above).torque) * breakdown_use < std::abs(wanted)) return std::nullopt;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (below + above);
      (std::abs(of(middle).torque) < std::abs(wanted) ? below : above) = middle;
    }
    return of(below);
  }
};

/// One period at a demand, with the most that the capability allows for it.
template <class T>
T step_once(OptimalFlux<T>& flux, FluxDemand<T> demand, TorqueCapability<T>& capability, T dt) {
  demand.most = capability.flux_share(demand.torque);
  return flux.step(demand, capability, dt);
}

/// The settled share of the flux reference for a torque at a speed.
template <class T>
T settled(const Case& c, FluxOptimum optimum, double omega_m, double torque) {
  typename TorqueCapability<T>::Parameters limits{.flux_reference = T(c.psi),
                                                  .breakdown_use = T(c.breakdown_use),
                                                  .current_limit = T(c.current),
                                                  .torque = T(c.torque)};
  const InductionMachineParameters<>& m = c.machine;
  limits.machine = {.r_s = T(m.r_s),
                    .r_r = T(m.r_r),
                    .l_ls = T(m.l_ls),
                    .l_lr = T(m.l_lr),
                    .l_m = T(m.l_m),
                    .pole_pairs = m.pole_pairs,
                    .inertia = T(m.inertia)};
  TorqueCapability<T> capability{limits};
  OptimalFlux<T> flux{
      {.optimum = optimum, .least_share = T(c.least_share), .iron_loss_resistance = T(c.r_fe)}, limits};
  T share{};
  for (int k = 0; k < 400; ++k) {
    capability.step(T(omega_m), T(c.u_dc), T(1));
    share = step_once(flux, {.torque = T(torque), .omega_m = T(omega_m)}, capability, T(1));
  }
  return share;
}

/// The least of a quantity over all fluxes at which the drive's limits allow the torque, and its share.
struct Least {
  double value{std::numeric_limits<double>::infinity()};
  double share{};
};
template <class Quantity>
Least least_of(const Case& c, double omega_m, double torque, const Quantity& quantity) {
  constexpr int steps = 500;
  Least found;
  for (int k = 0; k <= steps; ++k) {
    const double share = c.least_share + (1.0 - c.least_share) * k / steps;
    const auto circuit = c.at(share * c.psi, omega_m, torque);
    if (!circuit || circuit->current > c.current || circuit->voltage > c.u_dc / std::sqrt(3.0)) continue;
    if (quantity(*circuit) < found.value) found = {quantity(*circuit), share};
  }
  return found;
}

double current_of(const Circuit& circuit) {
  return circuit.current;
}
double loss_of(const Circuit& circuit) {
  return circuit.loss;
}

/// The least of its quantity is reached within a tolerance, and no limit is left.
template <class Quantity>
void expect_optimum(const Case& c, FluxOptimum optimum, double omega_m, double torque,
                    const Quantity& quantity, double tolerance = 0.001) {
  SCOPED_TRACE(std::to_string(torque) + " N·m at " + std::to_string(omega_m) + " rad/s");
  const Least least = least_of(c, omega_m, torque, quantity);
  if (least.share == 0.0) return;  // beyond the available torque
  const double share = settled<double>(c, optimum, omega_m, torque);
  const auto circuit = c.at(share * c.psi * (1.0 + 1e-6), omega_m, torque);
  ASSERT_TRUE(circuit) << share << " is beyond the breakdown, " << least.share << " is not";
  EXPECT_LE(quantity(*circuit), (1.0 + tolerance) * least.value) << share << " in place of " << least.share;
  EXPECT_LE(circuit->current, 1.001 * c.current);
  EXPECT_LE(circuit->voltage, 1.001 * c.u_dc / std::sqrt(3.0));
  EXPECT_GE(share, c.least_share * (1.0 - 1e-12));
  EXPECT_LE(share, 1.0);
}

template <class T>
class OptimalFluxOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(OptimalFluxOf, Scalars);

TYPED_TEST(OptimalFluxOf, TheLeastCurrentIsThatOfEqualCurrentsAlongAndAcrossTheRotorFlux) {
  using T = TypeParam;
  const Case c;
  const InductionMachineParameters<> m;
  for (const double torque : {-30.0, -5.0, 5.0, 15.0, 30.0}) {
    const double i_d = std::sqrt(std::abs(torque) / (1.5 * m.pole_pairs * (m.l_s() - m.sigma_l_s())));
    const double psi = i_d * std::hypot(m.l_s(), m.sigma_l_s());
    const T share = settled<T>(c, FluxOptimum::max_torque_per_ampere, 50, torque);
    EXPECT_NEAR(double(share), psi / c.psi, 1e-5);
  }
}

TYPED_TEST(OptimalFluxOf, WithoutIronLossTheLeastLossIsThatOfTheKnownRatioOfCurrents) {
  using T = TypeParam;
  const Case c;
  const InductionMachineParameters<> m;
  const double ratio = std::sqrt((m.r_s + m.k_r() * m.k_r() * m.r_r) / m.r_s);
  for (const double omega_m : {-100.0, 0.0, 100.0}) {
    const double product = 15.0 / (1.5 * m.pole_pairs * (m.l_s() - m.sigma_l_s()));  // i_d i_q
    const double psi =
        std::hypot(m.l_s() * std::sqrt(product * ratio), m.sigma_l_s() * std::sqrt(product / ratio));
    const T share = settled<T>(c, FluxOptimum::min_loss, omega_m, 15);
    EXPECT_NEAR(double(share), psi / c.psi, 1e-5);
  }
}

TYPED_TEST(OptimalFluxOf, StaysBetweenItsLeastShareAndTheConfiguredFlux) {
  using T = TypeParam;
  Case c;
  c.least_share = 0.35;
  for (const FluxOptimum optimum : {FluxOptimum::max_torque_per_ampere, FluxOptimum::min_loss}) {
    EXPECT_NEAR(settled<T>(c, optimum, 50, 0), T(0.35), T(1e-6));
    EXPECT_NEAR(settled<T>(c, optimum, 50, 1), T(0.35), T(1e-6));
    EXPECT_EQ(settled<T>(c, optimum, 50, 60), T(1));
  }
  EXPECT_EQ(settled<T>(c, FluxOptimum::constant, 50, 0), T(1));
}

TEST(OptimalFlux, TheLeastStatorCurrentIsThatOfTheCircuit) {
  const Case c;
  for (const double omega_m : {-300.0, -150.0, -50.0, 0.0, 50.0, 150.0, 200.0, 300.0, 400.0}) {
    for (const double torque : {2.0, 8.0, 15.0, 27.0, 45.0, 100.0}) {
      expect_optimum(c, FluxOptimum::max_torque_per_ampere, omega_m, torque, current_of);
    }
  }
}

TEST(OptimalFlux, TheLeastLossIsThatOfTheCircuit) {
  for (const double r_fe : {no_iron_loss, 2000.0, 500.0, 50.0}) {
    SCOPED_TRACE(r_fe);
    Case c;
    c.r_fe = r_fe;
    for (const double omega_m : {-300.0, -150.0, -50.0, 0.0, 50.0, 150.0, 200.0, 300.0, 400.0}) {
      for (const double torque : {2.0, 8.0, 15.0, 27.0, 45.0, 100.0}) {
        expect_optimum(c, FluxOptimum::min_loss, omega_m, torque, loss_of);
      }
    }
  }
}

TEST(OptimalFlux, IronLossLowersTheFluxOnlyAsFarAsTheCurrentLimitAllows) {
  Case c;
  c.r_fe = 5;
  c.current = 25;
  for (const double torque : {5.0, 15.0, 30.0, 40.0, 50.0}) {
    expect_optimum(c, FluxOptimum::min_loss, 100, torque, loss_of);
  }
  const double share = settled<double>(c, FluxOptimum::min_loss, 100, 40);
  const auto circuit = c.at(share * c.psi, 100, 40);
  ASSERT_TRUE(circuit.has_value());
  EXPECT_NEAR(circuit->current, 25.0, 1e-3) << "the limit counts here";
}

TEST(OptimalFlux, IronLossLowersTheFluxOnlyAsFarAsTheBreakdownTorqueAllows) {
  Case c;
  c.r_fe = 0.05;
  c.current = 1e4;
  c.breakdown_use = 0.3;
  c.least_share = 0.01;
  const double share = settled<double>(c, FluxOptimum::min_loss, 120, 20);
  EXPECT_NEAR(20.0 / breakdown_torque(c.machine, share * c.psi), 0.3, 1e-6);
}

// There the resistances decide, and less flux soon takes more voltage; then the flux is that of the largest
// torque and not the least possible.
TEST(OptimalFlux, OnALinkThatIsShortAtStandstillTheVoltageSuffices) {
  for (const double u_dc : {12.0, 15.0, 20.0, 30.0}) {
    for (const double omega_m : {0.0, 1.0, 3.0, 6.0, -1.0, -3.0, -6.0}) {
      for (const double load : {0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
        for (const double r_fe : {no_iron_loss, 10.0}) {
          Case c;
          c.u_dc = u_dc;
          c.r_fe = r_fe;
          const AvailableTorque<> available = TorqueCapability<>{c.limits()}.at(omega_m, u_dc);
          const double torque = load * available.side(1.0, omega_m).torque;
          SCOPED_TRACE(std::to_string(u_dc) + " V");
          expect_optimum(c, FluxOptimum::max_torque_per_ampere, omega_m, torque, current_of, 0.3);
          expect_optimum(c, FluxOptimum::min_loss, omega_m, torque, loss_of, 0.3);
        }
      }
    }
  }
}

/// A machine with all of its relative quantities at random.
Case random_case(std::mt19937& random) {
  const auto between = [&random](double low, double high) {
    return std::exp(std::uniform_real_distribution<double>{std::log(low), std::log(high)}(random));
  };
  Case c;
  const double impedance = between(0.05, 100.0);  // [Ω]
  const double omega = between(150.0, 1500.0);    // rated, electrical [rad/s]
  c.machine = {.r_s = impedance * between(0.005, 0.08),
               .r_r = impedance * between(0.005, 0.08),
               .l_ls = impedance * between(0.03, 0.15) / omega,
               .l_lr = impedance * between(0.03, 0.15) / omega,
               .l_m = impedance * between(1.2, 4.0) / omega,
               .pole_pairs = std::uniform_int_distribution{1, 6}(random)};
  c.psi = between(0.05, 1.5);
  c.u_dc = std::sqrt(3.0) * omega * c.psi * between(0.8, 1.3);
  c.current = c.psi / c.machine.l_s() * between(2.0, 12.0);
  c.torque = breakdown_torque(c.machine, c.psi) * between(0.1, 0.9);
  c.r_fe = between(0.2, 1e3) * impedance;
  c.least_share = between(0.1, 0.5);
  return c;
}

// Over the whole range of speed, with iron losses up to those of a machine with the flux's current in iron.
TEST(OptimalFlux, TheOptimaOfRandomMachinesAreThoseOfTheirCircuits) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> unit{0.0, 1.0};
  int weakened = 0;
  for (int k = 0; k < 150; ++k) {
    SCOPED_TRACE(testing::Message() << "machine " << k);
    const Case c = random_case(random);
    ASSERT_EQ(c.limits().validate(), nullptr);
    const double top = 2.5 * zero_torque_speed(c.machine, c.psi, c.u_dc);
    const TorqueCapability<> capability{c.limits()};
    for (int point = 0; point < 3; ++point) {
      const double omega_m = top * unit(random);
      const double sign = point == 1 ? -1.0 : 1.0;
      const auto side = capability.at(omega_m, c.u_dc).side(sign, omega_m);
      const double torque = sign * 0.98 * unit(random) * side.torque;
      const double share = settled<double>(c, FluxOptimum::constant, omega_m, torque);
      weakened += share < 1.0 ? 1 : 0;
      expect_optimum(c, FluxOptimum::max_torque_per_ampere, omega_m, torque, current_of);
      expect_optimum(c, FluxOptimum::min_loss, omega_m, torque, loss_of);
    }
  }
  EXPECT_GT(weakened, 100);
}

TYPED_TEST(OptimalFluxOf, RisesAtOnceAndFallsWithThreeRotorTimeConstants) {
  using T = TypeParam;
  constexpr T dt = T(1e-4);
  const typename TorqueCapability<T>::Parameters limits{};
  TorqueCapability<T> capability{limits};
  OptimalFlux<T> flux{{.optimum = FluxOptimum::max_torque_per_ampere}, limits};
  const auto step = [&](T torque) {
    capability.step(T(0), T(530), T(1));
    return step_once(flux, {.torque = torque}, capability, dt);
  };
  const T high = step(T(60));
  EXPECT_EQ(high, T(1));
  const int steps = int(std::lround(3.0 * double(limits.machine.tau_r()) / double(dt)));
  T share{};
  for (int k = 0; k < steps; ++k) share = step(T(0));
  EXPECT_NEAR(share, T(0.4) + T(0.6) * std::exp(T(-1)), T(2e-3));
  // A torque that comes and goes holds the flux that it needs.
  for (int k = 0; k < 10 * steps; ++k) share = step(k % 20 == 0 ? T(15) : T(0));
  EXPECT_NEAR(share, T(settled<T>(Case{}, FluxOptimum::max_torque_per_ampere, 0, 15)), T(2e-3));
  EXPECT_EQ(step(T(60)), T(1));
}

TYPED_TEST(OptimalFluxOf, TakesTheMostThatTheSpeedRangeAllowsWhereFluxLimitsTheTorque) {
  using T = TypeParam;
  const typename TorqueCapability<T>::Parameters limits{};
  TorqueCapability<T> capability{limits};
  TorqueCapability<T> alone{limits};
  OptimalFlux<T> flux{{.optimum = FluxOptimum::min_loss}, limits};
  for (int k = 0; k < 400; ++k) {
    capability.step(T(250), T(530), T(1));
    alone.step(T(250), T(530), T(1));
    const T share =
        step_once(flux, {.torque = T(5), .omega_m = T(250), .needs_full_flux = true}, capability, T(1));
    EXPECT_EQ(share, alone.flux_share(T(5)));
  }
}

TYPED_TEST(OptimalFluxOf, WithoutALinkOrASpeedTheFluxIsANumberAndNothingOfItStays) {
  using T = TypeParam;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  const T infinity = std::numeric_limits<T>::infinity();
  const typename TorqueCapability<T>::Parameters limits{};
  TorqueCapability<T> capability{limits};
  OptimalFlux<T> flux{{.optimum = FluxOptimum::min_loss, .iron_loss_resistance = T(500)}, limits};
  for (const T torque : {T(0), T(15), T(-15)}) {
    for (const T omega_m : {T(0), nan, infinity}) {
      for (const T u_dc : {T(0), T(-1), nan}) {
        capability.step(omega_m, u_dc, T(1));
        const T share = step_once(flux, {.torque = torque, .omega_m = omega_m}, capability, T(1e-3));
        EXPECT_GT(share, T(0));
        EXPECT_LE(share, T(1));
      }
    }
  }
  T share{};
  for (int k = 0; k < 400; ++k) {
    capability.step(T(50), T(530), T(1));
    share = step_once(flux, {.torque = T(15), .omega_m = T(50)}, capability, T(1));
  }
  Case c;
  c.r_fe = 500;
  EXPECT_NEAR(share, settled<T>(c, FluxOptimum::min_loss, 50, 15), T(1e-5));
}

TEST(OptimalFlux, RefusesParametersThatCannotWork) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Parameters = OptimalFlux<>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const double share : {0.0, -0.1, 1.1, nan}) {
    EXPECT_NE((Parameters{.least_share = share}.validate()), nullptr);
  }
  for (const double resistance : {0.0, -1.0, nan}) {
    EXPECT_NE((Parameters{.iron_loss_resistance = resistance}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
