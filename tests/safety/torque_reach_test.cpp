#include "sextant/safety/torque_reach.hpp"

#include <cmath>
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
    voltage = across.imag() / std::abs(circuit.psi_r);
    inputs.psi_r = {T(circuit.psi_r.real()), T(circuit.psi_r.imag())};
    inputs.i_s = {T(circuit.i_s.real()), T(circuit.i_s.imag())};
    inputs.omega_m = T(omega_m);
    // Any torque is reached at once.
    inputs.u_dc = T(1e6);
    reach.step(inputs, T(circuit.torque), T(tolerance), T(dt));
  }

  /// dτ_e/dt towards a command with this voltage in every direction [V]. [N·m/s]
  double slope(double u, double command) {
    inputs.u_dc = T(u * std::numbers::pi / std::numbers::sqrt3);
    reach.step(inputs, T(command), T(tolerance), T(dt));
    return (double(reach.torque()) - circuit.torque) / dt;
  }

  const InductionMachineParameters<double> machine = unlike_machine();
  EquivalentCircuit circuit;
  TorqueReach<T> reach;
  ReachInputs<T> inputs{};
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

// A reading of the link below zero, within what its sensor reads, holds the torque as a link without voltage
// does.
TYPED_TEST(TorqueReachOf, ALinkThatReadsBelowZeroIsOneWithoutVoltage) {
  Held<TypeParam> empty{30.0, 4.0};
  Held<TypeParam> negative{30.0, 4.0};
  EXPECT_EQ(negative.slope(-300.0, 1e3), empty.slope(0.0, 1e3));
}

}  // namespace
}  // namespace sextant
