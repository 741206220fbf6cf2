#include "sextant/plant/electrical_transition.hpp"

#include <cmath>
#include <complex>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include "sextant/plant/induction_machine.hpp"

namespace sextant {
namespace {

using Complex = std::complex<long double>;
using Vector = Eigen::Matrix<Complex, 2, 1>;

/// h phi_1(hA) x by Eigen's exponential in extended precision: the last column of exp of [hA, hx; 0, 0].
Vector expected(const ElectricalRates<double>& r, double omega_e, double h, const FluxPair<double>& x) {
  Eigen::Matrix<Complex, 3, 3> block;
  block << Complex{-r.ss}, Complex{r.sr}, Complex{x.s.alpha, x.s.beta},  //
      Complex{r.rs}, Complex{-r.rr, omega_e}, Complex{x.r.alpha, x.r.beta}, Complex{}, Complex{}, Complex{};
  const Eigen::Matrix<Complex, 3, 3> scaled = block * Complex{h};
  const Eigen::Matrix<Complex, 3, 3> exponential = scaled.exp();
  return exponential.topRightCorner<2, 1>();
}

void expect_exact(const ElectricalRates<double>& rates, double omega_e, double h) {
  SCOPED_TRACE(::testing::Message() << "omega_e " << omega_e << " h " << h);
  const FluxPair<double> x{{300.0, -120.0}, {35.0, 210.0}};
  ElectricalTransition<double> transition;
  transition.prepare(rates, omega_e, h);
  const FluxPair<double> y = transition(x);
  const Vector truth = expected(rates, omega_e, h, x);
  const double scale = double(truth.norm());
  EXPECT_LT(std::abs(Complex{y.s.alpha, y.s.beta} - truth[0]), 5e-13 * scale);
  EXPECT_LT(std::abs(Complex{y.r.alpha, y.r.beta} - truth[1]), 5e-13 * scale);
}

TEST(ElectricalTransition, IsExactForAnyTimeAndSpeed) {
  const ElectricalRates<double> rates = InductionMachine<double>{{}}.electrical_rates();
  for (const double omega_e : {0.0, 1e-3, 100.0, -314.0, 2000.0}) {
    for (const double h : {1e-6, 25e-6, 1e-4, 1e-3, 1e-2, 0.1}) expect_exact(rates, omega_e, h);
  }
}

TEST(ElectricalTransition, IsExactWhereEigenvaluesMeet) {
  // ss = rr and sr rs = 0: a double eigenvalue, of which the closed form by eigenvalues makes 0/0.
  for (const double sr : {0.0, 1e-9, 50.0}) expect_exact({200.0, sr, 0.0, 200.0}, 0.0, 1e-3);
  expect_exact({1e-3, 1e-4, 1e-4, 1e-3}, 0.0, 25e-6);
}

TEST(ElectricalTransition, IsExactForRandomMachines) {
  std::random_device device;
  const unsigned seed = device();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  const auto draw = [&random](double low, double high) {
    return std::exp(std::uniform_real_distribution{std::log(low), std::log(high)}(random));
  };
  for (int n = 0; n < 300; ++n) {
    InductionMachineParameters<double> p{};
    p.r_s = draw(1e-3, 10.0);
    p.r_r = draw(1e-3, 10.0);
    p.l_m = draw(1e-3, 1.0);
    p.l_ls = p.l_m * draw(0.01, 0.2);
    p.l_lr = p.l_m * draw(0.01, 0.2);
    expect_exact(InductionMachine<double>{p}.electrical_rates(), draw(1.0, 5000.0), draw(1e-7, 1e-3));
  }
}

TEST(ElectricalTransition, FloatFollowsDouble) {
  ElectricalTransition<float> single;
  ElectricalTransition<double> exact;
  for (const double h : {25e-6, 1e-3}) {
    single.prepare(InductionMachine<float>{{}}.electrical_rates(), 150.0F, float(h));
    exact.prepare(InductionMachine<double>{{}}.electrical_rates(), 150.0, h);
    const FluxPair<float> y = single({{300.0F, -120.0F}, {35.0F, 210.0F}});
    const FluxPair<double> truth = exact({{300.0, -120.0}, {35.0, 210.0}});
    EXPECT_NEAR(double(y.s.alpha), truth.s.alpha, 300 * h * 1e-5);
    EXPECT_NEAR(double(y.r.beta), truth.r.beta, 300 * h * 1e-5);
  }
}

TEST(ElectricalTransition, ASpeedWithoutEndEnds) {
  ElectricalTransition<double> transition;
  for (const double omega_e : {1e300, double(INFINITY), -double(INFINITY), double(NAN)}) {
    transition.prepare(InductionMachine<double>{{}}.electrical_rates(), omega_e, 25e-6);
    EXPECT_FALSE(std::isfinite(transition({{1.0, 0.0}, {0.0, 1.0}}).r.alpha));
  }
}

}  // namespace
}  // namespace sextant
