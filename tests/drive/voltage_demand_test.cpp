#include "sextant/drive/voltage_demand.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

/// The slip frequency of the breakdown torque at constant stator flux by stepping through the circuit.
/// [rad/s]
double breakdown_slip(const InductionMachineParameters<double>& m) {
  const auto torque = [&m](double slip) { return EquivalentCircuit::of_flux(m, 0.0, slip, 1.0).torque; };
  double low = 0.0;
  double high = 1e4;
  for (int k = 0; k < 200; ++k) {  // golden-section search
    const double a = high - 0.618033988749895 * (high - low);
    const double b = low + 0.618033988749895 * (high - low);
    (torque(a) < torque(b) ? low : high) = torque(a) < torque(b) ? a : b;
  }
  return 0.5 * (low + high);
}

template <class T>
class VoltageDemandOf : public testing::Test {
 protected:
  InductionMachineParameters<double> machine{unlike_machine()};
  typename VoltageDemand<T>::Machine parts{in_scalar<T>(machine)};

  /// |u_s|² (1 + x²) of the circuit at 1 Wb.
  [[nodiscard]] double by_circuit(double omega_r, double x) const {
    const double slip = x * breakdown_slip(machine);
    const auto c = EquivalentCircuit::of_flux(machine, omega_r / machine.pole_pairs, slip, 1.0);
    return std::norm(c.u_s) * (1.0 + x * x);
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(VoltageDemandOf, Scalars);

constexpr double speeds[] = {-400.0, -60.0, -5.0, 0.0, 5.0, 60.0, 400.0};
constexpr double slips[] = {0.0, 0.15, 0.5, 0.8, 1.0};

TYPED_TEST(VoltageDemandOf, IsTheVoltageOfTheCircuit) {
  using T = TypeParam;
  for (const double omega_r : speeds) {
    const VoltageDemand<T> demand{this->parts, T(omega_r)};
    EXPECT_NEAR(double(demand.without_torque()), this->by_circuit(omega_r, 0.0),
                1e-5 * this->by_circuit(omega_r, 0.0));
    for (const double x : slips) {
      const double expected = this->by_circuit(omega_r, x);
      // What is added: the rounding of the terms, which may cancel.
      EXPECT_NEAR(double(demand.at(T(x))), expected, 1e-5 * (this->by_circuit(std::abs(omega_r), x)))
          << omega_r << ' ' << x;
    }
  }
}

TYPED_TEST(VoltageDemandOf, ItsSlopeIsThatOfTheCircuit) {
  using T = TypeParam;
  for (const double omega_r : speeds) {
    const VoltageDemand<T> demand{this->parts, T(omega_r)};
    for (const double x : slips) {
      const double h = 1e-3;
      const double expected =
          (8.0 * (this->by_circuit(omega_r, x + h) - this->by_circuit(omega_r, x - h)) -
           (this->by_circuit(omega_r, x + 2.0 * h) - this->by_circuit(omega_r, x - 2.0 * h))) /
          (12.0 * h);
      EXPECT_NEAR(double(demand.slope(T(x))), expected, 1e-4 * this->by_circuit(std::abs(omega_r) + 60.0, x))
          << omega_r << ' ' << x;
    }
  }
}

// The torque at constant voltage of the circuit itself, |ψ|² for 1 V.
TYPED_TEST(VoltageDemandOf, TheTorqueRisesWhereThatOfTheCircuitAtConstantVoltageDoes) {
  using T = TypeParam;
  const double breakdown = breakdown_slip(this->machine);
  const auto torque = [&](double omega_r, double x) {
    const double omega_m = omega_r / this->machine.pole_pairs;
    const auto c = EquivalentCircuit::of_flux(this->machine, omega_m, x * breakdown, 1.0);
    return c.torque / std::norm(c.u_s);
  };
  int rising = 0;
  int falling = 0;
  for (const double omega_r : speeds) {
    const VoltageDemand<T> demand{this->parts, T(omega_r)};
    for (double x = 0.005; x < 1.0; x += 0.01) {
      const double change = torque(omega_r, x * 1.001) - torque(omega_r, x * 0.999);
      if (std::abs(change) < 1e-5 * torque(omega_r, x)) continue;  // at the top
      EXPECT_EQ(demand.torque_rises(T(x)), change > 0.0) << omega_r << ' ' << x;
      ++(change > 0.0 ? rising : falling);
    }
  }
  EXPECT_GT(rising, 20);
  EXPECT_GT(falling, 20);
}

}  // namespace
}  // namespace sextant
