#include "sextant/control/current_model.hpp"

#include <complex>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"

namespace sextant {
namespace {

constexpr unsigned seed = 20240507;

template <class T>
class CurrentModelOf : public testing::Test {
 protected:
  const InductionMachineParameters<double> actual{};
  const InductionMachineParameters<T> believed{test::converted<T>(actual)};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CurrentModelOf, Scalars);

// Under a constant current ψ_r(t) = ψ_∞ + (ψ_0 − ψ_∞) exp((−1/τ_r + j p ω_m) t).
TYPED_TEST(CurrentModelOf, FollowsTheExactSolutionUnderAConstantCurrent) {
  using T = TypeParam;
  using Complex = std::complex<double>;
  for (const double omega_m : {-140.0, -10.0, 0.0, 75.0}) {
    CurrentModel<T> model{this->believed};
    model.set({T(0.9), T(-0.3)});
    const Complex lambda{-1 / this->actual.tau_r(), this->actual.pole_pairs * omega_m};
    const Complex i{12, -5};
    const Complex limit = -this->actual.l_m / this->actual.tau_r() * i / lambda;
    const int steps = 4000;
    for (int k = 0; k < steps; ++k) model.step({T(12), T(-5)}, T(omega_m), T(25e-6));
    const Complex exact = limit + (Complex{0.9, -0.3} - limit) * std::exp(lambda * (25e-6 * steps));
    const double tolerance = 2.0 * steps * double(std::numeric_limits<T>::epsilon());
    EXPECT_NEAR(double(model.psi_r().alpha), exact.real(), tolerance) << omega_m;
    EXPECT_NEAR(double(model.psi_r().beta), exact.imag(), tolerance) << omega_m;
  }
}

// A drive that was late asks for the whole gap at once.
TYPED_TEST(CurrentModelOf, OneStepOfAnyLengthIsTheExactSolution) {
  using T = TypeParam;
  using Complex = std::complex<double>;
  for (const double dt : {1e-3, 5e-3, 20e-3, 50e-3, 1.0}) {
    for (const double omega_m : {-150.0, 0.0, 0.01, 100.0}) {
      SCOPED_TRACE(testing::Message() << dt << " s at " << omega_m << " rad/s");
      CurrentModel<T> model{this->believed};
      model.set({T(0.9), T(-0.3)});
      model.step({T(12), T(-5)}, T(omega_m), T(dt));
      const Complex lambda{-1 / this->actual.tau_r(), this->actual.pole_pairs * omega_m};
      const Complex limit = -this->actual.l_m / this->actual.tau_r() * Complex{12, -5} / lambda;
      const Complex exact = limit + (Complex{0.9, -0.3} - limit) * std::exp(lambda * dt);
      const double turned = 1.0 + std::abs(lambda) * dt;  // rounding of the angle
      const double series = std::abs(lambda) * dt < 0.05 ? 1e-9 : 0.0;
      const double tolerance = 10.0 * turned * double(std::numeric_limits<T>::epsilon()) + series;
      EXPECT_NEAR(double(model.psi_r().alpha), exact.real(), tolerance);
      EXPECT_NEAR(double(model.psi_r().beta), exact.imag(), tolerance);
    }
  }
}

TYPED_TEST(CurrentModelOf, StatorAndRotorFluxAreEachOthersInverse) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<T> flux{T(-1.5), T(1.5)};
  std::uniform_real_distribution<T> current{T(-100), T(100)};
  CurrentModel<T> model{this->believed};
  for (int i = 0; i < 200; ++i) {
    const SpaceVector<T> psi_r{flux(random), flux(random)};
    const SpaceVector<T> i_s{current(random), current(random)};
    model.set(psi_r);
    const SpaceVector<T> back = model.psi_r_from(model.psi_s(i_s), i_s);
    EXPECT_NEAR(back.alpha, psi_r.alpha, T(20) * std::numeric_limits<T>::epsilon());
    EXPECT_NEAR(back.beta, psi_r.beta, T(20) * std::numeric_limits<T>::epsilon());
  }
}

// The stator flux of the model is that of a machine with the same rotor flux and current.
TYPED_TEST(CurrentModelOf, AgreesWithTheInductanceMatrix) {
  using T = TypeParam;
  test::ReferenceMachine machine{this->actual};
  machine.psi_s = {1.0, 0.2};
  machine.psi_r = {0.9, 0.3};
  CurrentModel<T> model{this->believed};
  model.set({T(0.9), T(0.3)});
  const auto i = machine.i_s();
  const SpaceVector<T> psi_s = model.psi_s({T(i.real()), T(i.imag())});
  EXPECT_NEAR(psi_s.alpha, T(1.0), T(20) * std::numeric_limits<T>::epsilon());
  EXPECT_NEAR(psi_s.beta, T(0.2), T(20) * std::numeric_limits<T>::epsilon());
}

}  // namespace
}  // namespace sextant
