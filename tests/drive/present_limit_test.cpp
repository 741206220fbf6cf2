#include "sextant/drive/present_limit.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sextant/core/steady_state.hpp"
#include "support/equivalent_circuit.hpp"

namespace sextant {
namespace {

constexpr unsigned seed = 20240611;

/// Flux and current of the T-equivalent circuit at a relative slip, turned by an angle.
template <class T>
struct State {
  SpaceVector<T> psi_s;
  SpaceVector<T> i_s;

  State(const InductionMachineParameters<>& m, double psi, double x, double angle) {
    using Complex = std::complex<double>;
    const Complex j{0.0, 1.0};
    const double slip = x * m.l_s() / (m.sigma_l_s() * m.tau_r());
    const Complex i_r_by_i_s = -j * slip * m.l_m / (m.r_r + j * slip * m.l_r());
    const Complex turn = std::polar(1.0, angle);
    const Complex i = turn * psi / (m.l_s() + m.l_m * i_r_by_i_s);
    psi_s = {T((turn * psi).real()), T((turn * psi).imag())};
    i_s = {T(i.real()), T(i.imag())};
  }
};

template <class T>
class PresentLimitOf : public testing::Test {
 protected:
  static constexpr double psi_ref = 1.1;
  static constexpr T enough = T(1e6);
  InductionMachineParameters<> machine{};
  PresentLimit<T> limit{InductionMachineParameters<T>{}, T(psi_ref), T(60)};

  /// Torque of a flux and a current, 3/2 p ψ × i. [N·m]
  static double torque_of(SpaceVector<T> psi, SpaceVector<T> i) { return 3.0 * double(cross(psi, i)); }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PresentLimitOf, Scalars);

// With the current that the limit adds across the flux to the one along it, |i_s| is the limit.
TYPED_TEST(PresentLimitOf, TheTorqueOfTheLimitTakesTheWholeCurrentWithWhatFlowsAlongTheFlux) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> unit{-1.0, 1.0};
  for (int k = 0; k < 1000; ++k) {
    const SpaceVector<T> psi{T(unit(random)), T(unit(random))};
    if (magnitude(psi) < T(0.12)) continue;
    const SpaceVector<T> i{T(40 * unit(random)), T(40 * unit(random))};
    const LimitedTorque<T> found = this->limit.step(psi, i, T(1), this->enough);
    EXPECT_EQ(found.cause, DeratingCause::current_limit);
    const double along = double(dot(psi, i) / magnitude(psi));
    const double across = double(found.torque) / (3.0 * double(magnitude(psi)));
    EXPECT_NEAR(std::hypot(along, across), 60.0, 0.01);
  }
}

TYPED_TEST(PresentLimitOf, IsNoneWhereItIsMoreThanEnough) {
  using T = TypeParam;
  const T found = this->limit.step({T(1), T(0)}, {T(10), T(20)}, T(1), this->enough).torque;
  EXPECT_EQ(this->limit.step({T(1), T(0)}, {T(10), T(20)}, T(1), T(1.01) * found).torque, found);
  const LimitedTorque<T> none = this->limit.step({T(1), T(0)}, {T(10), T(20)}, T(1), T(0.99) * found);
  EXPECT_EQ(none.torque, std::numeric_limits<T>::infinity());
  EXPECT_EQ(none.cause, DeratingCause::none);
}

TYPED_TEST(PresentLimitOf, NothingIsLeftForTorqueWhereTheFluxTakesTheWholeCurrent) {
  using T = TypeParam;
  EXPECT_EQ(this->limit.step({T(1), T(0)}, {T(61), T(0)}, T(1), this->enough).torque, T(0));
  EXPECT_EQ(this->limit.step({T(1), T(0)}, {T(-61), T(0)}, T(1), this->enough).torque, T(0));
  EXPECT_GT(this->limit.step({T(1), T(0)}, {T(59), T(0)}, T(1), this->enough).torque, T(0));
}

TYPED_TEST(PresentLimitOf, AMachineWithoutFluxMayStart) {
  using T = TypeParam;
  EXPECT_NEAR(this->limit.step({}, {}, T(1), this->enough).torque, T(3 * 0.11 * 60), T(1e-3));
  EXPECT_GT(this->limit.step({}, {}, T(0.34), this->enough).torque, T(1.5))
      << "beyond the torque band of 0.9 N·m";
  EXPECT_LT(this->limit.step({}, {}, T(0.34), this->enough).torque, T(2.5));
}

TYPED_TEST(PresentLimitOf, UpToTheBreakdownTheWeakenedFluxAllowsAtLeastTheTorqueThatIsThere) {
  using T = TypeParam;
  for (const double psi : {0.35, 0.6, 1.0}) {
    for (const double angle : {0.0, 1.0, 4.0}) {
      for (const double x : {-0.85, -0.72, -0.3, 0.0, 0.3, 0.72, 0.85}) {
        PresentLimit<T> wide{InductionMachineParameters<T>{}, T(1.1), T(1e3)};
        const State<T> s{this->machine, psi, x, angle};
        const LimitedTorque<T> found = wide.step(s.psi_s, s.i_s, T(psi / 1.1), this->enough);
        EXPECT_EQ(found.cause, DeratingCause::voltage_limit);
        EXPECT_GE(double(found.torque), std::abs(this->torque_of(s.psi_s, s.i_s)));
      }
      // Beyond 42° of angle, tan δ = x, the limit is below the torque, which turns the machine back.
      for (const double x : {-3.0, -1.0, 1.0, 3.0}) {
        PresentLimit<T> wide{InductionMachineParameters<T>{}, T(1.1), T(1e3)};
        const State<T> s{this->machine, psi, x, angle};
        const T found = wide.step(s.psi_s, s.i_s, T(psi / 1.1), this->enough).torque;
        const double ratio = std::sin(42.0 * std::acos(-1.0) / 180.0) / std::sin(std::atan(std::abs(x)));
        EXPECT_NEAR(double(found), ratio * std::abs(this->torque_of(s.psi_s, s.i_s)), 0.002 * double(found));
      }
    }
  }
}

TYPED_TEST(PresentLimitOf, AtTheFullFluxTheAngleIsNoLimit) {
  using T = TypeParam;
  const State<T> s{this->machine, 1.1, 3.0, 0.0};
  PresentLimit<T> wide{InductionMachineParameters<T>{}, T(1.1), T(1e3)};
  EXPECT_EQ(wide.step(s.psi_s, s.i_s, T(1), this->enough).cause, DeratingCause::current_limit);
}

// A machine with unlike factors; every limit is that of its circuit.
TYPED_TEST(PresentLimitOf, OfAnotherMachineIsThatOfItsCircuit) {
  using T = TypeParam;
  const auto m = unlike_machine();
  const double reference_flux = 0.7;
  const double sigma_l_s = m.l_ls + m.l_m - m.l_m * m.l_m / (m.l_lr + m.l_m);
  const PresentLimit<T> narrow{in_scalar<T>(m), T(reference_flux), T(40)};
  const PresentLimit<T> wide{in_scalar<T>(m), T(reference_flux), T(1e4)};
  for (const double slip : {-25.0, 4.0, 20.0}) {
    const auto c = EquivalentCircuit::of_flux(m, 0.0, slip, 0.6);
    const SpaceVector<T> psi{T(c.psi_s.real()), T(c.psi_s.imag())};
    const SpaceVector<T> i{T(c.i_s.real()), T(c.i_s.imag())};
    // The current along the flux and what is left of 40 A across it.
    const double across = std::sqrt(40.0 * 40.0 - c.i_s.real() * c.i_s.real());
    EXPECT_NEAR(double(narrow.step(psi, i, T(1), this->enough).torque), 1.5 * 3.0 * 0.6 * across, 0.05)
        << slip;
    // The circuit's own torque, turned from the angle between its fluxes to 42 degrees.
    const double angle = std::abs(std::arg(c.psi_s / c.psi_r));
    const double pull_out = std::abs(c.torque) * std::sin(42.0 * std::acos(-1.0) / 180.0) / std::sin(angle);
    EXPECT_NEAR(double(wide.step(psi, i, T(0.9), this->enough).torque), pull_out, 1e-3 * pull_out) << slip;
  }
  // Without rotor flux a twentieth of the breakdown torque is left, at √0.1 of the flux reference at least.
  for (const double psi : {0.0, 0.5}) {
    double breakdown = 0.0;
    const double counted = std::max(psi, std::sqrt(0.1) * reference_flux);
    for (double slip = 0.0; slip < 200.0; slip += 0.05) {
      breakdown = std::max(breakdown, EquivalentCircuit::of_flux(m, 0.0, slip, counted).torque);
    }
    const SpaceVector<T> i{T(psi / sigma_l_s), T(0)};
    const double found = double(wide.step({T(psi), T(0)}, i, T(0.9), this->enough).torque);
    EXPECT_NEAR(found, 0.05 * breakdown, 1e-3 * breakdown) << psi;
  }
}

}  // namespace
}  // namespace sextant
