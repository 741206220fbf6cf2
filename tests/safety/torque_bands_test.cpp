#include "sextant/safety/torque_bands.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

using Complex = std::complex<double>;

/// Shares of which no function coincides with its reciprocal.
template <class T>
TorqueMonitorLimits<T> monitor_limits() {
  return {.machine = in_scalar<T>(unlike_machine()),
          .flux_reference = T(0.7),
          .r_s_share = T(0.3),
          .r_r_share = T(0.4),
          .l_m_share = T(0.2),
          .sensor_share = T(0),
          .current_offset = T(0)};
}

/// The means of an averaging time in which the circuit is in steady state. The flux is that of the monitor's
/// machine.
template <class T>
TorqueMeans<T> means_of(const EquivalentCircuit& c, double omega_m) {
  const auto m = unlike_machine();
  const Complex power = std::conj(c.i_s) * (c.u_s - m.r_s * c.i_s);
  const Complex flux_current = std::conj(c.psi_r) * c.i_s;
  return {.duration = T(1e-3),
          .omega_m = T(omega_m),
          .current_squared = T(std::norm(c.i_s)),
          .flux_squared = T(std::norm(c.psi_r)),
          .along = T(flux_current.real()),
          .across = T(flux_current.imag()),
          .power = T(power.real())};
}

/// The candidates' own fluxes have settled.
template <class T>
TorqueBands<T> settled(const TorqueMonitorLimits<T>& limits, const TorqueMeans<T>& means) {
  TorqueBands<T> bands{limits};
  for (int k = 0; k < 5000; ++k) bands.step(means);
  return bands;
}

struct Ends {
  double lowest;
  double highest;
};

/// Over the machine itself and the four corners, each as a circuit with the same current and slip.
Ends ends_by_current(const EquivalentCircuit& c, double omega_m) {
  Ends ends{c.torque, c.torque};
  for (const double r_r : {1.0 / 1.4, 1.0 / 0.6}) {
    for (const double l_m : {1.0 / 1.2, 1.0 / 0.8}) {
      auto m = unlike_machine();
      const double omega_slip = c.omega_e - m.pole_pairs * omega_m;
      m.r_r *= r_r;
      m.l_m *= l_m;
      const double torque = EquivalentCircuit{m, omega_m, omega_slip, c.i_s}.torque;
      ends = {std::min(ends.lowest, torque), std::max(ends.highest, torque)};
    }
  }
  return ends;
}

/// The torque that is left of the measured power where R_s is 0.7 times that given, or 1/0.7 times.
Ends ends_by_power(const EquivalentCircuit& c) {
  const auto m = unlike_machine();
  std::array<double, 2> ends{};
  std::size_t n = 0;
  for (const double share : {0.7, 1.0 / 0.7}) {
    const double input = (std::conj(c.i_s) * c.u_s).real();
    ends[n++] = 1.5 * m.pole_pairs * (input - share * m.r_s * std::norm(c.i_s)) / c.omega_e;
  }
  return {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
}

template <class T>
class TorqueBandsOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueBandsOf, Scalars);

TYPED_TEST(TorqueBandsOf, EndWhereTheCircuitsOfTheErrorsDo) {
  using T = TypeParam;
  for (const double omega_m : {-80.0, 25.0, 150.0}) {
    for (const double omega_slip : {-12.0, 3.0, 9.0}) {
      SCOPED_TRACE(testing::Message() << omega_m << " rad/s, slip " << omega_slip);
      const EquivalentCircuit c{unlike_machine(), omega_m, omega_slip, {25.0, 11.0}};
      const TorqueBands<T> bands = settled(monitor_limits<T>(), means_of<T>(c, omega_m));
      const double near = 5e-4 * std::abs(c.torque) + 2e-3;
      EXPECT_NEAR(double(bands.by_current().torque), c.torque, near);
      EXPECT_NEAR(double(bands.by_current().lowest), ends_by_current(c, omega_m).lowest, near);
      EXPECT_NEAR(double(bands.by_current().highest), ends_by_current(c, omega_m).highest, near);
      ASSERT_TRUE(bands.has_power());
      EXPECT_NEAR(double(bands.by_power().torque), c.torque, near);
      EXPECT_NEAR(double(bands.by_power().lowest), ends_by_power(c).lowest, near);
      EXPECT_NEAR(double(bands.by_power().highest), ends_by_power(c).highest, near);
    }
  }
}

TYPED_TEST(TorqueBandsOf, GainsAndOffsetsOfTheSensorsAddToBothEnds) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const EquivalentCircuit c{m, 60.0, 5.0, {25.0, 11.0}};
  const TorqueMeans<T> means = means_of<T>(c, 60.0);
  TorqueMonitorLimits<T> wide = monitor_limits<T>();
  wide.sensor_share = T(0.07);
  wide.current_offset = T(0.9);
  const TorqueBands<T> without = settled(monitor_limits<T>(), means);
  const TorqueBands<T> with = settled(wide, means);
  const double offset = 1.5 * m.pole_pairs * 0.9;
  const double by_power = 0.07 * c.torque + offset * std::abs(c.psi_r);
  const double by_current = by_power + offset * m.l_m * std::abs(c.i_s);
  EXPECT_NEAR(double(without.by_current().lowest - with.by_current().lowest), by_current, 0.01);
  EXPECT_NEAR(double(with.by_current().highest - without.by_current().highest), by_current, 0.01);
  EXPECT_NEAR(double(without.by_power().lowest - with.by_power().lowest), by_power, 0.01);
  EXPECT_NEAR(double(with.by_power().highest - without.by_power().highest), by_power, 0.01);
}

// A voltage error along the current is a power of 3/2 δu |i_s|, whose torque is that power by ω_e/p.
TYPED_TEST(TorqueBandsOf, AStatedErrorOfTheVoltageWidensTheBandByPower) {
  using T = TypeParam;
  const auto m = unlike_machine();
  for (const double omega_m : {-80.0, 60.0}) {
    const EquivalentCircuit c{m, omega_m, 5.0, {25.0, 11.0}};
    const TorqueMeans<T> means = means_of<T>(c, omega_m);
    TorqueMonitorLimits<T> wide = monitor_limits<T>();
    wide.inverter.voltage_error = T(1.5);
    const TorqueBands<T> without = settled(monitor_limits<T>(), means);
    const TorqueBands<T> with = settled(wide, means);
    const double torque = 1.5 * m.pole_pairs * 3.0 * std::abs(c.i_s) / std::abs(c.omega_e);
    const double near = 0.01 * torque;
    EXPECT_NEAR(double(without.by_power().lowest - with.by_power().lowest), torque, near);
    EXPECT_NEAR(double(with.by_power().highest - without.by_power().highest), torque, near);
    EXPECT_EQ(with.by_current().lowest, without.by_current().lowest);
  }
}

// The candidates' fluxes decay with time constants from 1/1.4·0.8 to 1/0.6·1.2 of each other; the flux is
// that before.
TYPED_TEST(TorqueBandsOf, WithoutCurrentEachFluxDecaysWithItsOwnTimeConstant) {
  using T = TypeParam;
  const EquivalentCircuit c{unlike_machine(), 60.0, 5.0, {25.0, 11.0}};
  const TorqueMeans<T> means = means_of<T>(c, 60.0);
  for (const double r_r : {1.0 / 1.4, 1.0 / 0.6}) {
    const double l_m = 1.0 / 0.8;
    auto m = unlike_machine();
    const double own_rate_before = m.r_r / (m.l_lr + m.l_m);
    m.r_r *= r_r;
    m.l_m *= l_m;
    const double rate = m.r_r / (m.l_lr + m.l_m);
    CandidateMachine<T> candidate{in_scalar<T>(unlike_machine()), T(r_r), T(l_m), T(1e-9)};
    for (int k = 0; k < 5000; ++k) candidate.step(means);
    const double before = double(candidate.torque(means).by_current);
    EXPECT_NEAR(before, EquivalentCircuit(m, 60.0, 5.0, c.i_s).torque, 0.01);
    candidate.decay(T(0.02));
    // Beside the monitor's own decay, which is that of the means.
    const double expected = before * std::exp((own_rate_before - rate) * 0.02);
    EXPECT_NEAR(double(candidate.torque(means).by_current), expected, 1e-3 * std::abs(before));
  }
}

// Flux that grows and turns as it likes: the rotor's equation gives its derivative, and this the power.
TYPED_TEST(TorqueBandsOf, TheTorqueByPowerIsRightWhileTheFluxChanges) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const double rate = m.r_r / (m.l_lr + m.l_m);
  const double k_r = m.l_m / (m.l_lr + m.l_m);
  for (const Complex i : {Complex{60.0, 20.0}, Complex{5.0, -40.0}}) {
    for (const double omega_m : {-50.0, 70.0}) {
      const Complex psi{0.6, 0.0};
      const Complex derivative = Complex{-rate, m.pole_pairs * omega_m} * psi + rate * m.l_m * i;
      const Complex flux_current = std::conj(psi) * i;
      const TorqueMeans<T> means{.duration = T(1e-3),
                                 .omega_m = T(omega_m),
                                 .current_squared = T(std::norm(i)),
                                 .flux_squared = T(std::norm(psi)),
                                 .along = T(flux_current.real()),
                                 .across = T(flux_current.imag()),
                                 .power = T((std::conj(i) * k_r * derivative).real())};
      const CandidateMachine<T> itself{in_scalar<T>(m), T(1), T(1), T(1e-9)};
      const CandidateTorque<T> found = itself.torque(means);
      const double torque = 1.5 * m.pole_pairs * k_r * flux_current.imag();
      EXPECT_NEAR(double(found.by_current), torque, 1e-4 * std::abs(torque));
      EXPECT_NEAR(double(found.by_power), torque, 1e-3 * std::abs(torque));
      EXPECT_NEAR(double(found.omega_e), (derivative / psi).imag(), 1e-3);
      EXPECT_NEAR(double(found.per_stator_ohm),
                  -1.5 * m.pole_pairs * std::norm(i) / (derivative / psi).imag(), 0.05);
    }
  }
}

// A current that steps: the fluxes of both machines by their own equations, in closed form.
TYPED_TEST(TorqueBandsOf, ACandidatesFluxFollowsItsOwnEquationAfterAStepOfTheCurrent) {
  using T = TypeParam;
  const double omega_m = 40.0;
  const Complex i{60.0, 20.0};
  const auto given = unlike_machine();
  auto own = given;
  own.r_r *= 1.0 / 0.6;
  own.l_m *= 1.0 / 1.2;
  const auto flux = [&](const InductionMachineParameters<double>& m, double t) {
    const double rate = m.r_r / (m.l_lr + m.l_m);
    const Complex pole{-rate, m.pole_pairs * omega_m};
    const Complex end = -rate * m.l_m * i / pole;
    return end * (1.0 - std::exp(pole * t));
  };
  const double dt = 1e-4;
  CandidateMachine<T> candidate{in_scalar<T>(given), T(1.0 / 0.6), T(1.0 / 1.2), T(1e-9)};
  for (int k = 1; k <= 300; ++k) {
    const Complex psi = flux(given, k * dt);
    const Complex flux_current = std::conj(psi) * i;
    const TorqueMeans<T> means{.duration = T(dt),
                               .omega_m = T(omega_m),
                               .current_squared = T(std::norm(i)),
                               .flux_squared = T(std::norm(psi)),
                               .along = T(flux_current.real()),
                               .across = T(flux_current.imag())};
    candidate.step(means);
    if (k % 50 != 0) continue;
    const double k_r = own.l_m / (own.l_lr + own.l_m);
    const double torque = 1.5 * own.pole_pairs * k_r * (std::conj(flux(own, k * dt)) * i).imag();
    EXPECT_NEAR(double(candidate.torque(means).by_current), torque, 0.1) << k;
  }
}

// The circuit of each corner of the errors has its own flux under the same current and slip.
TYPED_TEST(TorqueBandsOf, TheErrorOfTheFluxIsThatOfTheFurthestCircuit) {
  using T = TypeParam;
  for (const double omega_slip : {-12.0, 0.0, 3.0, 40.0}) {
    const EquivalentCircuit c{unlike_machine(), 60.0, omega_slip, {25.0, 11.0}};
    double furthest = 0.0;
    for (const double r_r : {1.0 / 1.4, 1.0 / 0.6}) {
      for (const double l_m : {1.0 / 1.2, 1.0 / 0.8}) {
        auto m = unlike_machine();
        m.r_r *= r_r;
        m.l_m *= l_m;
        furthest =
            std::max(furthest, std::abs(EquivalentCircuit(m, 60.0, omega_slip, c.i_s).psi_r / c.psi_r - 1.0));
      }
    }
    const TorqueBands<T> bands = settled(monitor_limits<T>(), means_of<T>(c, 60.0));
    EXPECT_NEAR(double(bands.flux_error()), furthest, 2e-3) << omega_slip;
  }
}

// The slowest candidate keeps its flux while that of the monitor decays: 1/0.8 L_m and 1/1.4 R_r.
TYPED_TEST(TorqueBandsOf, TheErrorOfTheFluxGrowsWhileItDecays) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const EquivalentCircuit c{m, 60.0, 0.0, {25.0, 11.0}};
  TorqueBands<T> bands = settled(monitor_limits<T>(), means_of<T>(c, 60.0));
  const double tau = (m.l_lr + m.l_m) / m.r_r;
  const double slowest = 1.4 * (m.l_lr + m.l_m / 0.8) / m.r_r;
  bands.decay(T(1.5 * tau));
  EXPECT_NEAR(double(bands.flux_error()), 1.25 * std::exp(1.5 - 1.5 * tau / slowest) - 1.0, 2e-3);
}

TYPED_TEST(TorqueBandsOf, WithoutOneSignOfTheFrequencyThereIsNoBandByPower) {
  using T = TypeParam;
  const EquivalentCircuit slow{unlike_machine(), -1.5, 5.0, {25.0, 11.0}};
  ASSERT_NEAR(slow.omega_e, 0.5, 1e-9);
  EXPECT_TRUE(settled(monitor_limits<T>(), means_of<T>(slow, -1.5)).has_power());
  // The fluxes of machines with other rotor resistances still turn towards their own places.
  TorqueBands<T> at_start{monitor_limits<T>()};
  for (int k = 0; k < 70; ++k) at_start.step(means_of<T>(slow, -1.5));
  EXPECT_FALSE(at_start.has_power());
  EXPECT_EQ(at_start.narrower().torque, at_start.by_current().torque);
}

}  // namespace
}  // namespace sextant
