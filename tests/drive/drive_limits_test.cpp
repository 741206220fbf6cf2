#include "sextant/drive/drive_limits.hpp"

#include <complex>

#include <gtest/gtest.h>

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
