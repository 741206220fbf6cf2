#include "sextant/safety/torque_reach.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

template <class T>
class TorqueReachOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueReachOf, Scalars);

constexpr double dt = 20e-6;
constexpr double tolerance = 0.5;  // [N·m]

/// A machine in a steady state of its equivalent circuit, whose torque needs a voltage across the rotor flux.
template <class T>
struct Held {
  explicit Held(double omega_m, double omega_slip)
      : circuit{machine, omega_m, omega_slip, {12.0, 5.0}}, reach{in_scalar<T>(machine), T(0.9)} {
    const auto across = std::conj(circuit.psi_r) * circuit.u_s;
    // A voltage across the stator flux is across the rotor flux by the cosine of the angle between both.
    const auto between = std::conj(circuit.psi_r) * circuit.psi_s;
    cosine = between.real() / std::abs(between);
    voltage = across.imag() / std::abs(circuit.psi_r);
    inputs.psi_r = {T(circuit.psi_r.real()), T(circuit.psi_r.imag())};
    inputs.i_s = {T(circuit.i_s.real()), T(circuit.i_s.imag())};
    inputs.omega_m = T(omega_m);
    // Any torque is reached at once.
    inputs.u_dc = T(1e6);
    reach.step(inputs, T(circuit.torque), T(tolerance), T(dt));
  }

  /// dτ_e/dt towards a command with this voltage across the rotor flux in either direction [V]. [N·m/s]
  double slope(double u, double command) {
    inputs.u_dc = T(u / cosine * std::numbers::pi / std::numbers::sqrt3);
    reach.step(inputs, T(command), T(tolerance), T(dt));
    return (double(reach.torque()) - circuit.torque) / dt;
  }

  const InductionMachineParameters<double> machine = unlike_machine();
  EquivalentCircuit circuit;
  TorqueReach<T> reach;
  ReachInputs<T> inputs{};
  double cosine{};   ///< of the angle between both fluxes [-]
  double voltage{};  ///< of the steady state, across the rotor flux [V]
};

// K = 3/2 p k_r/(σL_s) by the inductances themselves.
double gain(const InductionMachineParameters<double>& m) {
  const double l_s = m.l_ls + m.l_m;
  const double l_r = m.l_lr + m.l_m;
  return 1.5 * m.pole_pairs * m.l_m / (l_s * l_r - m.l_m * m.l_m);
}

// Of the voltage of the steady state nothing is left to change its torque; each volt more changes it by
// K |ψ_r| a second. In reverse the same with the other sign.
TYPED_TEST(TorqueReachOf, RiseIsWhatTheVoltageBeyondTheSteadyStateMakes) {
  for (const double omega_m : {30.0, 200.0}) {
    for (const double omega_slip : {8.0, -5.0}) {
      for (const double sign : {1.0, -1.0}) {
        for (const double more : {-20.0, 0.0, 15.0}) {
          SCOPED_TRACE(testing::Message()
                       << sign * omega_m << " rad/s, " << omega_slip << ", " << more << " V");
          Held<TypeParam> held{sign * omega_m, sign * omega_slip};
          const double per_volt = gain(held.machine) * std::abs(held.circuit.psi_r);
          const double u = sign * held.voltage + more;
          EXPECT_NEAR(held.slope(u, sign * 1e4), sign * per_volt * more, 0.002 * per_volt * u);
        }
      }
    }
  }
}

/// A machine by its flux linkages and inductances, under a switching table that changes the torque in one
/// direction for as long as it is asked and holds the magnitude of the stator flux.
struct TableDrive {
  using Complex = std::complex<double>;

  [[nodiscard]] double determinant() const { return (m.l_ls + m.l_m) * (m.l_lr + m.l_m) - m.l_m * m.l_m; }
  [[nodiscard]] Complex i_s() const { return ((m.l_lr + m.l_m) * psi_s - m.l_m * psi_r) / determinant(); }
  [[nodiscard]] Complex i_r() const { return ((m.l_ls + m.l_m) * psi_r - m.l_m * psi_s) / determinant(); }
  [[nodiscard]] double torque() const { return 1.5 * m.pole_pairs * (std::conj(psi_s) * i_s()).imag(); }

  /// A period with the active vector of the table: 30° to 90° before the stator flux where it is too small,
  /// 90° to 150° where it is too large. rise: +1 or −1.
  void step(double u_dc, int rise) {
    constexpr double sixth = std::numbers::pi / 3.0;
    const int sector = int(std::lround(std::arg(psi_s) / sixth));
    const int vector = sector + rise * (std::abs(psi_s) < flux ? 1 : 2);
    const Complex u = std::polar(2.0 / 3.0 * u_dc, vector * sixth);
    constexpr int parts = 20;
    for (int k = 0; k < parts; ++k) {
      const Complex rotor = -m.r_r * i_r() + Complex{0.0, m.pole_pairs * omega_m} * psi_r;
      psi_s += dt / parts * (u - m.r_s * i_s());
      psi_r += dt / parts * rotor;
    }
  }

  InductionMachineParameters<double> m;
  double omega_m{};  ///< [rad/s]
  double flux{};     ///< that the table holds [Wb]
  Complex psi_s{};   ///< [Wb]
  Complex psi_r{};   ///< [Wb]
};

/// The most by which what counts as reached is ahead of the torque of the machine on its way from a steady
/// state to a command, in torques of one vector for one period. [-]
double most_ahead(double omega_slip, double command, int rise, double spare) {
  constexpr double omega_m = 100.0;
  constexpr double flux = 0.9;
  const InductionMachineParameters<double> m = unlike_machine();
  const auto circuit = EquivalentCircuit::of_flux(m, omega_m, omega_slip, flux);
  TableDrive drive{m, omega_m, flux, circuit.psi_s, circuit.psi_r};
  // `spare` times what turns the stator flux with the rotor.
  const double u_dc = spare * m.pole_pairs * omega_m * flux * std::numbers::pi / std::numbers::sqrt3;
  const double vector = gain(m) * std::abs(circuit.psi_r) * 2.0 / 3.0 * u_dc * dt;
  TorqueReach<double> reach{m, flux};
  const auto step = [&](double torque, double link) {
    reach.step({vector_of(drive.psi_r), vector_of(drive.i_s()), omega_m, link}, torque, tolerance, dt);
  };
  step(drive.torque(), 1e6);
  double ahead = 0.0;
  for (double t = 0.0; t < 0.02 && rise * (command - drive.torque()) > vector; t += dt) {
    step(command, u_dc);
    drive.step(u_dc, rise);
    ahead = std::max(ahead, rise * (reach.torque() - drive.torque()));
  }
  return ahead / vector;
}

// Whatever the angle between both fluxes is: the vectors of the table are across the stator flux.
TEST(TorqueReach, IsNotAheadOfAMachineUnderASwitchingTable) {
  for (const double omega_slip : {-30.0, -20.0, -8.0, 0.0, 8.0, 20.0, 30.0}) {
    for (const double command : {-100.0, -40.0, 0.0, 40.0, 100.0}) {
      const double from = EquivalentCircuit::of_flux(unlike_machine(), 100.0, omega_slip, 0.9).torque;
      for (const double spare : {1.02, 1.1, 1.3, 2.0, 4.0}) {
        SCOPED_TRACE(testing::Message() << from << " to " << command << " N·m, " << spare);
        EXPECT_LE(most_ahead(omega_slip, command, command < from ? -1 : 1, spare), 1.0);
      }
    }
  }
}

TYPED_TEST(TorqueReachOf, FallIsWhatTheReversedVoltageMakes) {
  Held<TypeParam> held{100.0, 8.0};
  const double per_volt = gain(held.machine) * std::abs(held.circuit.psi_r);
  EXPECT_NEAR(held.slope(40.0, -1e4), -per_volt * (held.voltage + 40.0), 0.002 * per_volt * held.voltage);
}

TYPED_TEST(TorqueReachOf, WhatIsReachedFollowsATorqueThatIsNearer) {
  Held<TypeParam> held{100.0, 8.0};
  const double command = held.circuit.torque + 30.0;
  (void)held.slope(held.voltage, command);
  const auto follow = [&held, command](double below, double share) {
    held.reach.follow(TypeParam(command - below), TypeParam(tolerance), TypeParam(share));
    return command - double(held.reach.torque());
  };
  EXPECT_NEAR(follow(10.0, 0.25), 25.0, 0.1);
  EXPECT_NEAR(follow(27.0, 1.0), 25.0, 0.1);
  EXPECT_NEAR(follow(1.0, 1.0), 1.0, 0.1);
  EXPECT_GT(held.reach.lag(), TypeParam(0));
  EXPECT_NEAR(follow(0.4, 0.1), 0.0, 1e-3);
  EXPECT_EQ(held.reach.lag(), TypeParam(0));
}

TYPED_TEST(TorqueReachOf, AfterTwiceTheTransientRotorTimeConstantACommandCountsAsReached) {
  Held<TypeParam> held{100.0, 8.0};
  const InductionMachineParameters<double>& m = held.machine;
  const double sigma = 1.0 - m.l_m * m.l_m / ((m.l_ls + m.l_m) * (m.l_lr + m.l_m));
  const double longest = 2.0 * sigma * (m.l_lr + m.l_m) / m.r_r;
  for (const double command : {held.circuit.torque + 30.0, held.circuit.torque + 60.0}) {
    const auto periods = int(longest / dt);
    for (int k = 0; k < periods - 2; ++k) (void)held.slope(held.voltage, command);
    EXPECT_LT(double(held.reach.torque()), command - 10.0);
    EXPECT_NEAR(double(held.reach.lag()), longest, 4.0 * dt);
    for (int k = 0; k < 5; ++k) (void)held.slope(held.voltage, command);
    EXPECT_NEAR(double(held.reach.torque()), command, tolerance);
  }
}

TYPED_TEST(TorqueReachOf, AMachineWithoutFluxHasTheTimeOfATenthOfIt) {
  const InductionMachineParameters<double> m = unlike_machine();
  TorqueReach<TypeParam> reach{in_scalar<TypeParam>(m), TypeParam(0.9)};
  reach.step({.u_dc = TypeParam(500.0)}, TypeParam(1000), TypeParam(tolerance), TypeParam(dt));
  EXPECT_NEAR(double(reach.torque()), gain(m) * 0.09 * 500.0 * std::numbers::sqrt3 / std::numbers::pi * dt,
              1e-3);
  EXPECT_GT(reach.lag(), TypeParam(0));
  reach.reset();
  EXPECT_EQ(reach.torque(), TypeParam(0));
  EXPECT_EQ(reach.lag(), TypeParam(0));
}

TYPED_TEST(TorqueReachOf, BeyondTheAngleOfTheBreakdownTorqueTheVoltageActsAsAtThatAngle) {
  const InductionMachineParameters<double> m = unlike_machine();
  for (const double across : {40.0, 400.0}) {
    TorqueReach<TypeParam> reach{in_scalar<TypeParam>(m), TypeParam(0.9)};
    reach.step({.psi_r = {TypeParam(0.5), TypeParam(0)},
                .i_s = {TypeParam(0), TypeParam(across)},
                .u_dc = TypeParam(500.0)},
               TypeParam(1000), TypeParam(tolerance), TypeParam(dt));
    const double u = 500.0 * std::numbers::sqrt3 / std::numbers::pi * std::numbers::sqrt2 / 2.0;
    EXPECT_NEAR(double(reach.torque()), gain(m) * 0.5 * u * dt, 1e-3) << across << " A";
  }
}

// A reading of the link below zero, within what its sensor reads, holds the torque as a link without voltage
// does.
TYPED_TEST(TorqueReachOf, ALinkThatReadsBelowZeroIsOneWithoutVoltage) {
  Held<TypeParam> empty{30.0, 4.0};
  Held<TypeParam> negative{30.0, 4.0};
  EXPECT_EQ(negative.slope(-300.0, 1e3), empty.slope(0.0, 1e3));
}

}  // namespace
}  // namespace sextant
