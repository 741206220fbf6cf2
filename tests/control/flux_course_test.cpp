// The regression of the flux's course, on courses of machines that are known.
#include "sextant/control/flux_course.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "saturating_machine.hpp"

namespace sextant {
namespace {

constexpr double period = 25e-6;
constexpr double correlation = 8e-3;  // of the noise [s]

template <class T>
InductionMachineParameters<T> nominal() {
  return {};
}

/// Magnetising by 23 A to 1.03 Wb, in some 70 ms, of a machine that differs from the nominal one by factors,
/// with φ read with noise of that deviation [Wb] and the voltage along it off by `voltage` [V], of which the
/// course knows the deviation `voltage_error` [V].
template <class T>
typename FluxCourse<T>::Result identified(double r_s, double r_r, double l_r, double noise, unsigned seed,
                                          double voltage = 0, double voltage_error = 0) {
  const InductionMachineParameters<double> m = nominal<double>();
  const double a = r_r * m.k_r() * m.k_r() * m.r_r;
  const double b = r_r / l_r / m.tau_r();
  FluxCourse<T> course{nominal<T>(), T(correlation), T(voltage_error), T(1.1)};
  std::mt19937 generator{seed};
  std::normal_distribution<double> normal;
  const double current = 23;
  const double keep = std::exp(-2 * period / correlation);
  double phi = 0.2;
  double error = noise * normal(generator);
  while (phi < 1.03) {
    const double slope = (a * current - b * phi) / (1 + 0.5 * b * period);
    phi += period * slope;
    error = keep * error + std::sqrt(1 - keep * keep) * noise * normal(generator);
    course.add(T(r_s * m.r_s * current + voltage + slope), T(current), T(phi + error), T(period));
  }
  return course.solve();
}

template <class T>
class FluxCourseOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FluxCourseOf, Scalars);

TYPED_TEST(FluxCourseOf, WithoutNoiseItFindsAnyMachineWithinSomePercent) {
  using T = TypeParam;
  const auto m = nominal<double>();
  for (const double r_s : {0.5, 1.5}) {
    for (const double r_r : {0.5, 1.5}) {
      for (const double l_r : {0.7, 1.3}) {
        const auto found = identified<T>(r_s, r_r, l_r, 0, 0);
        EXPECT_NEAR(double(found.r_s) / m.r_s, r_s, 0.01);
        EXPECT_NEAR(double(found.r_r) / m.r_r, r_r, 0.05);
        EXPECT_NEAR(double(found.l_m) + m.l_lr, l_r * m.l_r(), 0.04 * m.l_r());
      }
    }
  }
}

// 6 V are 0.26 Ω at 23 A: R_s takes that share of them that its prior, 0.5 R_s, has beside it. R_r and L_r
// follow from the flux alone.
TYPED_TEST(FluxCourseOf, AnErrorOfTheVoltageIsSharedByThePriorOfTheStatorResistance) {
  using T = TypeParam;
  const auto m = nominal<double>();
  const double prior = 0.5 * m.r_s;
  const double error = 6.0 / 23.0;
  const double share = prior * prior / (prior * prior + error * error);
  const auto blind = identified<T>(1, 1, 1, 0, 0, 6.0, 0.0);
  const auto found = identified<T>(1, 1, 1, 0, 0, 6.0, 6.0);
  EXPECT_NEAR(double(blind.r_s), m.r_s + error, 0.01 * m.r_s);
  EXPECT_NEAR(double(found.r_s), m.r_s + share * error, 0.01 * m.r_s);
  EXPECT_EQ(found.r_r, blind.r_r);
  EXPECT_EQ(found.l_m, blind.l_m);
  EXPECT_GT(found.covariance.ss, blind.covariance.ss);
}

/// Magnetising by 23 A from 0.3 to 1.12 Wb of the nominal machine with iron that saturates: what shows is the
/// flux behind the leakage of the machine without.
template <class T>
typename FluxCourse<T>::Result found_of_iron(double saturation, FluxCourse<T> course) {
  const auto m = nominal<double>();
  const double current = 23;
  const double leakage = m.sigma_l_s() * current;
  SaturatingMachine machine{saturation};
  while (machine.psi_s() < 0.3) machine.advance(current, period);
  while (machine.psi_s() < 1.12) {
    const double before = machine.psi_s();
    machine.advance(current, period);
    const double slope = (machine.psi_s() - before) / period;
    course.add(T(m.r_s * current + slope), T(current), T(machine.psi_s() - leakage), T(period));
  }
  return course.solve();
}

// Up to half of the magnetising current at 1.1 Wb is the iron's. Where what shows is taken for k_r ψ_r, L_m
// is 19 % too low.
TYPED_TEST(FluxCourseOf, SaturationIsNotTakenForAParameter) {
  using T = TypeParam;
  const auto m = nominal<double>();
  for (const double saturation : {0.25, 0.5}) {
    SCOPED_TRACE(saturation);
    const auto found = found_of_iron<T>(saturation, {nominal<T>(), T(correlation), T(0), T(1.1)});
    EXPECT_NEAR(double(found.r_s) / m.r_s, 1, 0.01);
    EXPECT_NEAR(double(found.r_r) / m.r_r, 1, 0.01);
    EXPECT_NEAR(double(found.l_m) / m.l_m, 1, 0.005);
  }
}

// The same iron, whose curve is known but for a knee that is off by 2 %. R_r as configured is wrong.
TYPED_TEST(FluxCourseOf, AKnownCurveLeavesAWrongMachineToBeFound) {
  using T = TypeParam;
  const auto m = nominal<double>();
  for (const double believed : {0.7, 1.4}) {
    for (const double knee : {1.08, 1.1, 1.12}) {
      SCOPED_TRACE(testing::Message() << believed << ", " << knee << " Wb");
      auto configured = nominal<T>();
      configured.r_r *= T(believed);
      const SaturationParameters<T> curve{.knee = T(knee), .exponent = 7, .machine_flux = T(1.1)};
      const auto known = SaturationShape<T>::of(curve, T(1.1));
      const auto found = found_of_iron<T>(0.5, {configured, T(correlation), T(0), T(1.1), known});
      EXPECT_NEAR(double(found.r_s) / m.r_s, 1, 0.02);
      EXPECT_NEAR(double(found.r_r) / m.r_r, 1, 0.04);
      EXPECT_NEAR(double(found.l_m) / m.l_m, 1, 0.07);
    }
  }
}

// What is configured has a deviation of 25 % in R_r and of 15 % in L_r: noise adds none to them.
TYPED_TEST(FluxCourseOf, NoiseLeavesNoLargerErrorThanTheConfigurationHas) {
  using T = TypeParam;
  const auto m = nominal<double>();
  constexpr unsigned runs = 50;
  for (const double noise : {0.01, 0.05}) {
    double r_r = 0;
    double l_r = 0;
    for (unsigned seed = 0; seed < runs; ++seed) {
      const auto found = identified<T>(1, 1, 1, noise, seed);
      r_r += std::pow(double(found.r_r) / m.r_r - 1, 2) / runs;
      l_r += std::pow((double(found.l_m) + m.l_lr) / m.l_r() - 1, 2) / runs;
    }
    EXPECT_LT(std::sqrt(r_r), 0.125) << noise << " Wb";
    EXPECT_LT(std::sqrt(l_r), 0.15) << noise << " Wb";
  }
}

TYPED_TEST(FluxCourseOf, ACourseOfOnePeriodLeavesTheConfiguration) {
  using T = TypeParam;
  FluxCourse<T> course{nominal<T>(), T(correlation), T(0), T(1.1)};
  course.add(T(0), T(0), T(1), T(period));
  const auto found = course.solve();
  const auto m = nominal<T>();
  EXPECT_EQ(found.r_s, m.r_s);
  EXPECT_NEAR(double(found.r_r / m.r_r), 1, 1e-3);
  EXPECT_NEAR(double(found.l_m / m.l_m), 1, 1e-3);
  EXPECT_NEAR(double(found.flux), 1, 1e-5);
}

}  // namespace
}  // namespace sextant
