// The regression of the voltage at standstill, on courses of machines that are known.
#include "sextant/control/standstill_course.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "saturating_machine.hpp"

namespace sextant {
namespace {

constexpr double period = 25e-6;

/// What was found, by the true values, and the variance of R_s that is told. [-]
struct Found {
  double r_s;
  double r_r;
  double l_r;
  double flux;
  double variance;
};

/// What a course suffers.
struct Errors {
  double noise{};          ///< deviation of the leakage flux that is read [Wb]
  unsigned seed{};         ///< of the noise
  double voltage{};        ///< of the voltage [V]
  double voltage_error{};  ///< deviation of it that the course knows [V]
};

/// Magnetising from a dead machine, which differs from the nominal one by factors, by 22 A to a stator flux
/// of 1.1 Wb, at which its inductance is that of the factors, and then by the current that holds the rotor's.
template <class T>
Found identified(double duration, double r_s, double r_r, double l_r, const Errors& errors = {}) {
  const InductionMachineParameters<double> m;
  const double a = r_r * m.k_r() * m.k_r() * m.r_r;
  const double b = r_r / l_r / m.tau_r();
  StandstillCourse<T> course{InductionMachineParameters<T>{}, T(errors.voltage_error), T(1.1)};
  std::mt19937 generator{errors.seed};
  std::normal_distribution<double> normal;
  course.begin(T(0));
  double flux = 0;
  double error = 0;
  bool reached = false;
  for (int k = 0; k < int(duration / period); ++k) {
    reached = reached || flux + 22.0 * m.sigma_l_s() >= 1.1;
    const double current = reached ? b / a * (1.1 - 22.0 * m.sigma_l_s()) : 22.0;
    const double final_flux = a * current / b;
    const double next = final_flux + (flux - final_flux) * std::exp(-b * period);
    const double next_error = errors.noise * normal(generator);
    const double behind = r_s * m.r_s * current + (next + next_error - flux - error) / period;
    flux = next;
    error = next_error;
    course.add(T(behind + errors.voltage), T(current), T(period));
  }
  const auto found = course.result();
  return {double(found.r_s) / (r_s * m.r_s), double(found.r_r) / (r_r * m.r_r),
          (double(found.l_m) + m.l_lr) / (l_r * m.l_r()), double(found.flux) / flux,
          double(found.covariance.ss)};
}

template <class T>
class StandstillCourseOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(StandstillCourseOf, Scalars);

// After three rotor time constants the course has told everything.
TYPED_TEST(StandstillCourseOf, ALongCourseTellsAnyMachine) {
  for (const double r_s : {0.6, 1.5}) {
    for (const double r_r : {0.6, 1.5}) {
      for (const double l_r : {0.7, 1.3}) {
        SCOPED_TRACE(testing::Message() << r_s << ' ' << r_r << ' ' << l_r);
        const Found found = identified<TypeParam>(0.4, r_s, r_r, l_r);
        EXPECT_NEAR(found.r_s, 1, 0.08);
        EXPECT_NEAR(found.r_r, 1, 0.08);
        EXPECT_NEAR(found.l_r, 1, 0.13);
        EXPECT_NEAR(found.flux, 1, 0.08);
      }
    }
  }
}

// 100 ms, one rotor time constant, is what magnetising takes.
TYPED_TEST(StandstillCourseOf, ItTellsAWrongResistanceWithinTheTimeOfAStart) {
  const Found stator = identified<TypeParam>(0.1, 1.5, 1, 1);
  EXPECT_NEAR(stator.r_s, 1, 0.04);
  EXPECT_NEAR(stator.r_r, 1, 0.04);
  EXPECT_NEAR(stator.flux, 1, 0.05);
  const Found rotor = identified<TypeParam>(0.1, 1, 0.5, 1);
  EXPECT_NEAR(rotor.r_s, 1, 0.08);
  EXPECT_NEAR(rotor.r_r, 1, 0.06);
  EXPECT_NEAR(rotor.flux, 1, 0.1);
}

// Noise of 0.2 A in the current, with a leakage of 4.7 mH.
TYPED_TEST(StandstillCourseOf, NoiseOfTheSensorsLeavesAKnownMachineKnown) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Found found = identified<TypeParam>(0.1, 1, 1, 1, {.noise = 0.001, .seed = seed});
    EXPECT_NEAR(found.r_s, 1, 0.06);
    EXPECT_NEAR(found.r_r, 1, 0.04);
    EXPECT_NEAR(found.l_r, 1, 0.08);
  }
}

// The resistive voltage is 22 A · R_s, which an error of 4 V exceeds by 42 %. At a constant current it is
// shared by the priors of both, 0.5 R_s · 22 A and 4 V, and neither flux nor rotor are taken for it.
TYPED_TEST(StandstillCourseOf, AnErrorOfTheVoltageIsSharedByThePriors) {
  const InductionMachineParameters<double> m;
  for (const double voltage : {-4.0, 4.0}) {
    SCOPED_TRACE(voltage);
    const double by_r_s = 0.5 * m.r_s * 22;
    const double share = by_r_s * by_r_s / (by_r_s * by_r_s + 16);
    const Found found = identified<TypeParam>(0.06, 1, 1, 1, {.voltage = voltage, .voltage_error = 4.0});
    EXPECT_NEAR(found.r_s, 1 + share * voltage / (22 * m.r_s), 0.02);
    EXPECT_NEAR(found.r_r, 1, 0.02);
    EXPECT_NEAR(found.l_r, 1, 0.02);
    EXPECT_NEAR(found.flux, 1, 0.03);
    EXPECT_NEAR(found.variance, 0.25 * 16 / (by_r_s * by_r_s + 16), 0.02);
    const Found unaware = identified<TypeParam>(0.06, 1, 1, 1, {.voltage = voltage});
    EXPECT_NEAR(unaware.r_s, 1 + voltage / (22 * m.r_s), 0.05);
  }
}

/// Magnetising by 22 A, which flow after so many seconds, to 1.12 Wb of the nominal machine with iron that
/// saturates, without flux at first.
template <class T>
typename StandstillCourse<T>::Result found_of_iron(double saturation, StandstillCourse<T> course,
                                                   const Errors& errors = {}, double rise = 0) {
  const InductionMachineParameters<double> m;
  SaturatingMachine machine{saturation};
  std::mt19937 generator{errors.seed};
  std::normal_distribution<double> normal;
  course.begin(T(0));
  double behind = 0;
  for (int k = 1; machine.psi_s() < 1.12; ++k) {
    const double current = k * period < rise ? 22 * k * period / rise : 22;
    machine.advance(current, period);
    const double flux = machine.psi_s() - m.sigma_l_s() * current + errors.noise * normal(generator);
    course.add(T(m.r_s * current + errors.voltage + (flux - behind) / period), T(current), T(period));
    behind = flux;
  }
  return course.result();
}

// Up to half of the magnetising current at 1.1 Wb is the iron's. Where the flux behind the leakage of the
// unsaturated machine is taken for k_r ψ_r, R_r is 12 % too high.
TYPED_TEST(StandstillCourseOf, SaturationIsNotTakenForAResistance) {
  using T = TypeParam;
  const InductionMachineParameters<double> m;
  for (const double saturation : {0.25, 0.5}) {
    SCOPED_TRACE(saturation);
    const auto found = found_of_iron<T>(saturation, {InductionMachineParameters<T>{}, T(0), T(1.1)});
    EXPECT_NEAR(double(found.r_s) / m.r_s, 1, 0.04);
    EXPECT_NEAR(double(found.r_r) / m.r_r, 1, 0.03);
    EXPECT_NEAR(double(found.l_m) / m.l_m, 1, 0.05);
  }
}

// The same iron, whose curve is known but for a knee that is off by 2 %. R_r as configured is wrong.
TYPED_TEST(StandstillCourseOf, AKnownCurveLeavesAWrongMachineToBeFound) {
  using T = TypeParam;
  const InductionMachineParameters<double> m;
  for (const double believed : {0.7, 1.4}) {
    for (const double knee : {1.08, 1.1, 1.12}) {
      SCOPED_TRACE(testing::Message() << believed << ", " << knee << " Wb");
      InductionMachineParameters<T> configured;
      configured.r_r *= T(believed);
      const SaturationParameters<T> curve{.knee = T(knee), .exponent = 7, .machine_flux = T(1.1)};
      const auto known = SaturationShape<T>::of(curve, T(1.1));
      const auto found = found_of_iron<T>(0.5, {configured, T(0), T(1.1), known});
      EXPECT_NEAR(double(found.r_s) / m.r_s, 1, 0.06);
      EXPECT_NEAR(double(found.r_r) / m.r_r, 1, 0.06);
      EXPECT_NEAR(double(found.l_m) / m.l_m, 1, 0.1);
    }
  }
}

// Early in the course nothing tells R_s from the rotor's resistance: a flux by that R_s would drive the
// course of the iron, and this R_s and R_r, away.
TYPED_TEST(StandstillCourseOf, NoiseBesideAKnownCurveLeavesAKnownMachineKnown) {
  using T = TypeParam;
  const InductionMachineParameters<double> m;
  const auto known = SaturationShape<T>::of({.knee = T(1.1), .exponent = 7, .machine_flux = T(1.1)}, T(1.1));
  for (const double voltage : {-0.5, 0.5}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE(testing::Message() << voltage << " V, seed " << seed);
      const auto found = found_of_iron<T>(0.5, {InductionMachineParameters<T>{}, T(0.5), T(1.1), known},
                                          {.noise = 0.001, .seed = seed, .voltage = voltage}, 5e-3);
      EXPECT_NEAR(double(found.r_s) / m.r_s, 1, 0.08);
      EXPECT_NEAR(double(found.r_r) / m.r_r, 1, 0.1);
      EXPECT_NEAR(double(found.l_m) / m.l_m, 1, 0.05);
    }
  }
}

// Two levels of the current tell a resistance from a voltage.
TYPED_TEST(StandstillCourseOf, TwoLevelsOfTheCurrentTellAVoltageFromAResistance) {
  using T = TypeParam;
  const InductionMachineParameters<double> m;
  StandstillCourse<T> course{InductionMachineParameters<T>{}, T(4), T(1.1)};
  const double a = m.k_r() * m.k_r() * m.r_r;
  const double b = 1 / m.tau_r();
  double flux = 0;
  course.begin(T(0));
  for (int k = 0; k < int(1.0 / period); ++k) {
    const double current = k * period < 0.4 ? 22 : 8;
    const double final_flux = a * current / b;
    const double next = final_flux + (flux - final_flux) * std::exp(-b * period);
    course.add(T(1.3 * m.r_s * current + 3.0 + (next - flux) / period), T(current), T(period));
    flux = next;
  }
  EXPECT_NEAR(double(course.result().r_s) / m.r_s, 1.3, 0.03);
}

TYPED_TEST(StandstillCourseOf, WithoutACourseTheConfigurationStays) {
  using T = TypeParam;
  const InductionMachineParameters<T> m;
  StandstillCourse<T> course{m, T(0), T(1.1)};
  course.begin(T(0.3));
  const auto found = course.result();
  EXPECT_EQ(found.r_s, m.r_s);
  EXPECT_EQ(found.r_r, m.r_r);
  EXPECT_NEAR(double(found.l_m), double(m.l_m), 1e-7);
  EXPECT_EQ(found.flux, T(0.3));
}

}  // namespace
}  // namespace sextant
