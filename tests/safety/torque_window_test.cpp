#include "sextant/safety/torque_window.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

template <class T>
class TorqueWindowOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueWindowOf, Scalars);

// Two periods of unlike length under phase a's own vector, 2/3 u_dc along it, for all of the first and half
// of the second. The sums are written out here.
TYPED_TEST(TorqueWindowOf, MeansAreThoseOfThePeriodsAndThePowerIsThatBehindTheStator) {
  using T = TypeParam;
  const auto m = unlike_machine();
  TorqueWindow<T> window{in_scalar<T>(m)};
  const double first = 40e-6;
  const double second = 60e-6;
  window.add(GatePattern{switch_states[1], 40'000}, T(first), T(300), {T(10), T(4)}, {T(14), T(2)},
             {T(0.5), T(-0.2)}, T(30), T(7), T(3));
  GatePattern half{switch_states[0], 30'000};
  half.append({switch_states[1], 30'000});
  window.add(half, T(second), T(330), {T(14), T(2)}, {T(11), T(5)}, {T(0.45), T(-0.1)}, T(50), T(9), T(4));
  const double sigma_l_s = m.l_ls + m.l_m - m.l_m * m.l_m / (m.l_lr + m.l_m);
  // (∫u dt − R_s i dt − σL_s Δi) · i with the mean current of each period.
  const double first_alpha = 200.0 * first - m.r_s * 12.0 * first - sigma_l_s * 4.0;
  const double first_beta = -m.r_s * 3.0 * first - sigma_l_s * -2.0;
  const double second_alpha = 220.0 * 30e-6 - m.r_s * 12.5 * second - sigma_l_s * -3.0;
  const double second_beta = -m.r_s * 3.5 * second - sigma_l_s * 3.0;
  const double energy = first_alpha * 12.0 + first_beta * 3.0 + second_alpha * 12.5 + second_beta * 3.5;

  const TorqueMeans<T> means = window.means();
  EXPECT_NEAR(double(means.duration), 100e-6, 1e-10);
  EXPECT_NEAR(double(window.duration()), 100e-6, 1e-10);
  EXPECT_NEAR(double(means.commanded), 8.0, 1e-5);
  EXPECT_NEAR(double(means.reached), 3.5, 1e-5);
  EXPECT_NEAR(double(means.omega_m), 40.0, 1e-5);
  EXPECT_NEAR(double(means.current_squared), 0.5 * (200.0 + 146.0), 1e-4);
  EXPECT_NEAR(double(means.flux_squared), 0.5 * (0.29 + 0.2125), 1e-6);
  EXPECT_NEAR(double(means.along), 0.5 * (7.0 - 0.4 + 4.95 - 0.5), 1e-5);
  EXPECT_NEAR(double(means.across), 0.5 * (1.0 + 2.8 + 2.25 + 1.1), 1e-5);
  EXPECT_NEAR(double(means.power), energy / 100e-6, 1e-4 * std::abs(energy) / 100e-6 + 0.1);
  window.clear();
  EXPECT_EQ(window.duration(), T(0));
}

}  // namespace
}  // namespace sextant
