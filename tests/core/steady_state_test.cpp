#include "sextant/core/steady_state.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

template <class T>
class SteadyStateOf : public testing::Test {
 protected:
  static constexpr double psi = 0.7;
  InductionMachineParameters<double> machine{unlike_machine()};
  InductionMachineParameters<T> scalar{in_scalar<T>(machine)};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SteadyStateOf, Scalars);

TYPED_TEST(SteadyStateOf, IsThatOfTheCircuitAtItsSlip) {
  using T = TypeParam;
  for (const double x : {-1.0, -0.4, 0.0, 0.1, 0.7, 1.0}) {
    const SteadyState<T> found = steady_state(this->scalar, T(this->psi), T(x));
    const auto circuit = EquivalentCircuit::of_flux(this->machine, 0.0, double(found.omega_slip), this->psi);
    EXPECT_NEAR(double(found.torque), circuit.torque, 1e-3) << x;
    EXPECT_NEAR(double(found.i_d), circuit.i_s.real(), 1e-4) << x;
    EXPECT_NEAR(double(found.i_q), circuit.i_s.imag(), 1e-4) << x;
    EXPECT_NEAR(double(found.current()), std::abs(circuit.i_s), 1e-4) << x;
  }
}

TYPED_TEST(SteadyStateOf, NoSlipMakesMoreThanTheBreakdownTorqueAndSlipOneMakesIt) {
  using T = TypeParam;
  const double breakdown = double(breakdown_torque(this->scalar, T(this->psi)));
  double most = 0.0;
  for (double slip = 0.0; slip < 200.0; slip += 0.05) {
    most = std::max(most, EquivalentCircuit::of_flux(this->machine, 0.0, slip, this->psi).torque);
  }
  EXPECT_NEAR(breakdown, most, 1e-4 * most);
}

TYPED_TEST(SteadyStateOf, TheSlipOfATorqueMakesItInTheCircuit) {
  using T = TypeParam;
  const T breakdown = breakdown_torque(this->scalar, T(this->psi));
  for (const double share : {0.05, 0.4, 0.9, 0.999}) {
    const T x = relative_slip(T(share) * breakdown, breakdown);
    const double slip = double(steady_state(this->scalar, T(this->psi), x).omega_slip);
    const auto circuit = EquivalentCircuit::of_flux(this->machine, 0.0, slip, this->psi);
    EXPECT_NEAR(circuit.torque, share * double(breakdown), 1e-3) << share;
    EXPECT_LT(x, T(1));
  }
}

TYPED_TEST(SteadyStateOf, AtTheZeroTorqueSpeedTheCircuitTakesTheLinksWholeVoltage) {
  using T = TypeParam;
  for (const double u_dc : {40.0, 300.0}) {
    const double omega_m = double(zero_torque_speed(this->scalar, T(this->psi), T(u_dc)));
    ASSERT_GT(omega_m, 0.0);
    const auto circuit = EquivalentCircuit::of_flux(this->machine, omega_m, 0.0, this->psi);
    EXPECT_NEAR(std::abs(circuit.u_s), u_dc / std::sqrt(3.0), 1e-4 * u_dc);
  }
}

}  // namespace
}  // namespace sextant
