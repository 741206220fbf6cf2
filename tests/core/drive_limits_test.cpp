#include "sextant/core/drive_limits.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

template <class T>
class DriveLimitsOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DriveLimitsOf, Scalars);

// T_b = 3/4 p L_m²/(σ L_s² L_r) ψ²; the current at it from the circuit, at ω_slip = 1/(σ τ_r).
TYPED_TEST(DriveLimitsOf, FollowFromThePapersMachine) {
  using T = TypeParam;
  const InductionMachineParameters<T> m{};
  const double l_s = m.l_s();
  const double l_m = m.l_m;
  const double l_r = m.l_r();
  const double sigma = 1.0 - l_m * l_m / (l_s * l_r);
  const double breakdown = 0.75 * 2.0 * l_m * l_m / (sigma * l_s * l_s * l_r) * 1.1 * 1.1;
  EXPECT_NEAR(breakdown, 362.0, 1.0);
  const std::complex<double> jx{0.0, 1.0};
  const double current = std::abs(1.1 / l_s * (1.0 + jx / sigma) / (1.0 + jx));
  EXPECT_NEAR(current, 165.0, 1.0);

  const DriveLimits<T> limits = drive_limits(m, T(1.1), T(530));
  EXPECT_NEAR(limits.torque, 0.4 * breakdown, 0.05);
  EXPECT_NEAR(limits.over_current, 1.25 * current, 0.05);
  EXPECT_NEAR(limits.dc_over_voltage, 689.0, 0.01);
  EXPECT_NEAR(limits.over_speed, 487.0, 0.5);
  EXPECT_NEAR(limits.magnetising_current, 1.8 * 1.1 / l_s, 0.01);
  EXPECT_NEAR(limits.hand_over_current, 1.25 * 1.1 / l_s, 0.01);
  EXPECT_NEAR(limits.torque_band, 0.905, 0.005);
  EXPECT_NEAR(limits.flux_band, 0.011, 1e-6);
}

// Of a machine with unlike factors: every limit by its own circuit.
TYPED_TEST(DriveLimitsOf, FollowFromTheCircuitOfAnotherMachine) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const double psi = 0.7;
  const double u_dc = 400.0;
  EquivalentCircuit breakdown = EquivalentCircuit::of_flux(m, 0.0, 0.0, psi);
  const double rest_current = std::abs(breakdown.i_s);
  for (double slip = 0.0; slip < 60.0; slip += 0.002) {
    const auto c = EquivalentCircuit::of_flux(m, 0.0, slip, psi);
    if (c.torque > breakdown.torque) breakdown = c;
  }
  double low = 0.0;
  double high = 1e4;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const double voltage = std::abs(EquivalentCircuit::of_flux(m, middle, 0.0, psi).u_s);
    (voltage < u_dc / std::sqrt(3.0) ? low : high) = middle;
  }
  const DriveLimits<T> limits = drive_limits(in_scalar<T>(m), T(psi), T(u_dc));
  const auto expect = [](T found, double expected) { EXPECT_NEAR(double(found), expected, 1e-4 * expected); };
  expect(limits.torque, 0.4 * breakdown.torque);
  expect(limits.torque_band, 0.0025 * breakdown.torque);
  expect(limits.flux_band, 0.01 * psi);
  expect(limits.magnetising_current, 1.8 * rest_current);
  expect(limits.hand_over_current, 1.25 * rest_current);
  expect(limits.over_current, 1.25 * std::abs(breakdown.i_s));
  expect(limits.dc_over_voltage, 1.3 * u_dc);
  expect(limits.dc_under_voltage, 0.5 * u_dc);
  expect(limits.torque_deviation, 0.0275 * breakdown.torque);
  expect(limits.current_offset, 0.045 * rest_current);
  expect(limits.over_speed, 3.5 * low);
  expect(limits.speed_jump, 0.25 * low);
  expect(limits.speed_error, 0.2 * low);
}

TYPED_TEST(DriveLimitsOf, ThoseOfCurrentSensorsFollowFromTheTripLevelAndTheChangeByAVector) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const CurrentSensorLimits<T> limits = current_sensor_limits(in_scalar<T>(m), T(90), T(400), T(50e-6));
  const double sigma_l_s = m.l_ls + m.l_m - m.l_m * m.l_m / (m.l_lr + m.l_m);
  EXPECT_NEAR(double(limits.sum), 2.7, 1e-5);
  EXPECT_NEAR(double(limits.jump), 2.7 + 0.5 * 400.0 * 2.0 / 3.0 * 50e-6 / sigma_l_s, 1e-4);
  EXPECT_NEAR(double(limits.noise), 0.09, 1e-6);
  EXPECT_NEAR(double(limits.zero_current), 0.9, 1e-6);
}

TYPED_TEST(DriveLimitsOf, ScaleWithFluxAndLink) {
  using T = TypeParam;
  const InductionMachineParameters<T> m{};
  const DriveLimits<T> one = drive_limits(m, T(1), T(500));
  const DriveLimits<T> half = drive_limits(m, T(0.5), T(500));
  const DriveLimits<T> half_of_both = drive_limits(m, T(0.5), T(250));
  EXPECT_NEAR(half.torque, one.torque / T(4), T(1e-3));
  EXPECT_NEAR(half.over_current, one.over_current / T(2), T(1e-3));
  EXPECT_NEAR(half_of_both.over_speed, one.over_speed, T(1e-2));
  EXPECT_NEAR(half_of_both.dc_over_voltage, one.dc_over_voltage / T(2), T(1e-3));
}

TYPED_TEST(DriveLimitsOf, ALinkThatCannotFeedTheFluxLeavesNoSpeed) {
  using T = TypeParam;
  EXPECT_EQ(zero_torque_speed(InductionMachineParameters<T>{}, T(1.1), T(9)), T(0));
  EXPECT_GT(zero_torque_speed(InductionMachineParameters<T>{}, T(1.1), T(10)), T(0));
}

TYPED_TEST(DriveLimitsOf, TheSlipOfATorqueGivesThatTorque) {
  using T = TypeParam;
  const InductionMachineParameters<T> m{};
  const T breakdown = breakdown_torque(m, T(1.1));
  for (const T torque : {T(0), T(1), T(50), T(200), T(360)}) {
    EXPECT_NEAR(steady_state(m, T(1.1), relative_slip(torque, breakdown)).torque, torque, T(0.01));
  }
  EXPECT_EQ(relative_slip(T(2) * breakdown, breakdown), T(1));
}

}  // namespace
}  // namespace sextant
