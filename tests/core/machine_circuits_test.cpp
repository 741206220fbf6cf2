// Each circuit is solved as the network that it is; no conversion takes part in its own check.
#include "sextant/core/machine_circuits.hpp"

#include <cmath>
#include <complex>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace sextant {
namespace {

using Complex = std::complex<double>;
using Machine = InductionMachineParameters<>;

constexpr Complex j{0, 1};

Complex parallel(Complex a, Complex b) {
  return a * b / (a + b);
}

/// A network behind R_s: impedance, and the power that crosses the air gap by the square of the stator
/// current.
struct AtSlip {
  Complex impedance;
  double gap_power;
};

/// Stator leakage, magnetising branch, rotor branch: the T circuit, of which one leakage may be zero.
AtSlip network(double r_s, double l_ls, double l_m, double l_lr, double r_r, double omega, double slip) {
  const Complex magnetising = j * omega * l_m;
  const Complex rotor = r_r / slip + j * omega * l_lr;
  const Complex both = parallel(magnetising, rotor);
  const double share = std::norm(both / rotor);  // |i_r/i_s|²
  return {r_s + j * omega * l_ls + both, share * r_r / slip};
}
AtSlip t_network(const Machine& m, double omega, double slip) {
  return network(m.r_s, m.l_ls, m.l_m, m.l_lr, m.r_r, omega, slip);
}
AtSlip gamma_network(const Machine& m, const LeakageCircuit<>& c, double omega, double slip) {
  return network(m.r_s, 0, c.l_m, c.l_sigma, c.r_r, omega, slip);
}
AtSlip inverse_gamma_network(const Machine& m, const LeakageCircuit<>& c, double omega, double slip) {
  return network(m.r_s, c.l_sigma, c.l_m, 0, c.r_r, omega, slip);
}

/// Sum and product of the two eigenvalues of the flux linkages at a speed, u_s = 0, of a network: the
/// coefficients of det(s L + R) = 0 with the rotor's speed voltage, free of the scale of the rotor's turns.
struct Characteristic {
  Complex sum;
  Complex product;
};
Characteristic characteristic(double r_s, double l_ls, double l_m, double l_lr, double r_r, double omega) {
  const double l_s = l_ls + l_m, l_r = l_lr + l_m;
  const double det = l_s * l_r - l_m * l_m;
  // d/dt (psi_s, psi_r) = A (psi_s, psi_r), A = −R L⁻¹ + diag(0, jω)
  const Complex a11 = -r_s * l_r / det, a12 = r_s * l_m / det;
  const Complex a21 = r_r * l_m / det, a22 = -r_r * l_s / det + j * omega;
  return {a11 + a22, a11 * a22 - a12 * a21};
}

void expect_same(const AtSlip& a, const AtSlip& b) {
  EXPECT_LT(std::abs(a.impedance - b.impedance), 1e-12 * std::abs(a.impedance));
  EXPECT_NEAR(a.gap_power, b.gap_power, 1e-12 * std::abs(a.gap_power));
}
void expect_same(const Characteristic& a, const Characteristic& b) {
  EXPECT_LT(std::abs(a.sum - b.sum), 1e-12 * std::abs(a.sum));
  EXPECT_LT(std::abs(a.product - b.product), 1e-11 * std::abs(a.product));
}

class RandomMachines : public ::testing::Test {
 protected:
  static constexpr unsigned seed = 20261127;
  static constexpr int count = 200;

  void SetUp() override { RecordProperty("seed", int(seed)); }
  double draw(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }
  /// Between the ends of a decade or more.
  double spread(double low, double high) { return std::exp(draw(std::log(low), std::log(high))); }
  Machine machine() {
    Machine m;
    m.r_s = spread(0.005, 20);
    m.r_r = spread(0.005, 20);
    m.l_m = spread(0.001, 1);
    m.l_ls = m.l_m * spread(0.005, 0.2);
    m.l_lr = m.l_m * spread(0.005, 0.2);
    m.pole_pairs = 3;
    m.inertia = 0.25;
    return m;
  }
  LeakageCircuit<> circuit() {
    const double l_m = spread(0.001, 1);
    return {l_m, l_m * spread(0.01, 0.4), spread(0.005, 20)};
  }
  double slip() { return (draw(0, 1) < 0.5 ? -1 : 1) * spread(0.001, 2); }

 private:
  std::mt19937 random_{seed};
};

TEST_F(RandomMachines, AreOneMachineInEveryCircuit) {
  for (int n = 0; n < count; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const Machine m = machine();
    const LeakageCircuit<> g = gamma_circuit(m), i = inverse_gamma_circuit(m);
    for (int k = 0; k < 5; ++k) {
      const double omega = spread(1, 3000), s = slip();
      expect_same(t_network(m, omega, s), gamma_network(m, g, omega, s));
      expect_same(t_network(m, omega, s), inverse_gamma_network(m, i, omega, s));
      const Characteristic t = characteristic(m.r_s, m.l_ls, m.l_m, m.l_lr, m.r_r, omega);
      expect_same(t, characteristic(m.r_s, 0, g.l_m, g.l_sigma, g.r_r, omega));
      expect_same(t, characteristic(m.r_s, i.l_sigma, i.l_m, 0, i.r_r, omega));
    }
  }
}

TEST_F(RandomMachines, OfOtherCircuitsAreTheMachineOfTheirTCircuit) {
  for (int n = 0; n < count; ++n) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", case " + std::to_string(n));
    const Machine others = machine();
    const LeakageCircuit<> c = circuit();
    const Machine g = from_gamma(others, c), i = from_inverse_gamma(others, c);
    for (int k = 0; k < 5; ++k) {
      const double omega = spread(1, 3000), s = slip();
      expect_same(gamma_network(others, c, omega, s), t_network(g, omega, s));
      expect_same(inverse_gamma_network(others, c, omega, s), t_network(i, omega, s));
      expect_same(characteristic(others.r_s, 0, c.l_m, c.l_sigma, c.r_r, omega),
                  characteristic(g.r_s, g.l_ls, g.l_m, g.l_lr, g.r_r, omega));
      expect_same(characteristic(others.r_s, c.l_sigma, c.l_m, 0, c.r_r, omega),
                  characteristic(i.r_s, i.l_ls, i.l_m, i.l_lr, i.r_r, omega));
    }
    for (const Machine& m : {g, i}) {
      EXPECT_EQ(m.validate(), nullptr);
      EXPECT_EQ(m.l_ls, m.l_lr);
      EXPECT_EQ(m.r_s, others.r_s);
      EXPECT_EQ(m.pole_pairs, others.pole_pairs);
      EXPECT_EQ(m.inertia, others.inertia);
    }
  }
}

TEST(MachineCircuits, AMachineWithEqualLeakagesComesBack) {
  const Machine m;
  ASSERT_EQ(m.l_ls, m.l_lr);
  for (const Machine& back :
       {from_gamma(m, gamma_circuit(m)), from_inverse_gamma(m, inverse_gamma_circuit(m))}) {
    EXPECT_NEAR(back.l_ls, m.l_ls, 1e-14 * m.l_ls * 100);
    EXPECT_NEAR(back.l_lr, m.l_lr, 1e-14 * m.l_lr * 100);
    EXPECT_NEAR(back.l_m, m.l_m, 1e-14 * m.l_m);
    EXPECT_NEAR(back.r_r, m.r_r, 1e-14 * m.r_r);
  }
}

// Slemon's Γ and inverse-Γ elements of a machine by hand: L_s = 0.11, L_r = 0.105, L_m = 0.1.
TEST(MachineCircuits, ElementsByHand) {
  const Machine m{.r_s = 1, .r_r = 2, .l_ls = 0.01, .l_lr = 0.005, .l_m = 0.1};
  const LeakageCircuit<> g = gamma_circuit(m), i = inverse_gamma_circuit(m);
  EXPECT_NEAR(g.l_m, 0.11, 1e-15);
  EXPECT_NEAR(g.l_sigma, 0.01705, 1e-15);
  EXPECT_NEAR(g.r_r, 2.42, 1e-14);
  EXPECT_NEAR(i.l_m, 0.01 / 0.105, 1e-15);
  EXPECT_NEAR(i.l_sigma, 0.11 - 0.01 / 0.105, 1e-15);
  EXPECT_NEAR(i.r_r, 2 / 1.1025, 1e-14);
}

TEST(MachineCircuits, FloatAgreesWithDouble) {
  const LeakageCircuit<float> c{0.1F, 0.01F, 2.0F};
  const auto m = from_gamma(InductionMachineParameters<float>{}, c);
  const LeakageCircuit<float> back = gamma_circuit(m);
  EXPECT_NEAR(back.l_m, 0.1F, 1e-7F);
  EXPECT_NEAR(back.l_sigma, 0.01F, 1e-7F);
  EXPECT_NEAR(back.r_r, 2.0F, 1e-5F);
}

}  // namespace
}  // namespace sextant
