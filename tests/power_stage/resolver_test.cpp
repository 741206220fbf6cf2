// Angle and speed of a resolver: errors of its signals against first-order closed forms, its tracking loop
// against the response of a second-order loop of type II.
#include "sextant/power_stage/resolver.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "sextant/power_stage/sensor_model.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::int64_t period_ns = 50'000;

/// Errors of electrical angle [rad] and speed [rad/s] over one turn of the signals after a second.
void visit_errors(const ResolverParameters& p, double omega_m,
                  const std::function<void(double theta, double angle, double speed)>& visit) {
  Resolver resolver{p};
  const double electrical = p.pole_pairs * omega_m;
  resolver.begin(0, omega_m, 0);
  const std::int64_t end_ns = 1'000'000'000 + std::int64_t(2e9 * pi / electrical);
  for (std::int64_t t = period_ns; t < end_ns; t += period_ns) {
    const double theta_m = omega_m * (double(t) * 1e-9);
    resolver.step(theta_m, t);
    if (t < 1'000'000'000) continue;
    visit(p.pole_pairs * theta_m, p.pole_pairs * (resolver.theta() - theta_m),
          p.pole_pairs * (resolver.omega() - omega_m));
  }
}

/// Slowly turned, so that the loop follows: 2 rad/s of the signals beside 2π 300.
void expect_error(const ResolverParameters& p, const std::function<double(double)>& closed,
                  double tolerance) {
  visit_errors(p, 2.0 / p.pole_pairs, [&](double theta, double angle, double) {
    ASSERT_NEAR(angle, closed(theta), tolerance) << theta;
  });
}

TEST(Resolver, AmplitudeImbalanceIsASecondHarmonic) {
  expect_error(
      {.pole_pairs = 3, .amplitude_error = 0.01}, [](double x) { return 0.005 * std::sin(2 * x); }, 5e-5);
}

TEST(Resolver, QuadratureErrorIsASecondHarmonicAndAMean) {
  expect_error(
      {.pole_pairs = 3, .quadrature_error = 0.01}, [](double x) { return 0.005 * (std::cos(2 * x) - 1); },
      1e-4);
}

TEST(Resolver, OffsetsAreFirstHarmonics) {
  expect_error(
      {.pole_pairs = 2, .sine_offset = 0.01, .cosine_offset = -0.02},
      [](double x) { return 0.01 * std::cos(x) + 0.02 * std::sin(x); }, 4e-4);
}

TEST(Resolver, QuantisationIsWithinItsStep) {
  // Half a step of each signal, filtered by the loop: 4/2^10/2 √2.
  expect_error({.pole_pairs = 1, .bits = 10}, [](double) { return 0.0; }, 2.8e-3);
}

// Slow and fast beside the loop, and with the quantisation's steps near its own frequency: the bound holds
// for all, and a single step comes to 0.456/0.674 of it.
TEST(Resolver, QuantisationPutsNoMoreThanItsBoundOnTheSpeed) {
  for (const int bits : {6, 8, 10, 12}) {
    const ResolverParameters p{.pole_pairs = 2, .bits = bits, .bandwidth = 100};
    const double bound = 2 * std::numbers::sqrt2 / (1 << bits) * 0.95307 * 2 * pi * 100;
    double most = 0;
    for (const double electrical : {2.0, 11.0, 70.0, 400.0, 1500.0}) {
      visit_errors(p, electrical / 2,
                   [&most](double, double, double speed) { most = std::max(most, std::abs(speed)); });
    }
    EXPECT_LT(most, bound) << bits;
    EXPECT_GT(most, 0.15 * bound) << bits;
    EXPECT_NEAR(p.quantisation_error(), bound / 2, 1e-4 * bound);
  }
}

// A type II loop: at constant speed neither angle nor speed is wrong.
TEST(Resolver, HasNoErrorAtConstantSpeed) {
  visit_errors({.pole_pairs = 4}, 100, [](double, double angle, double speed) {
    ASSERT_NEAR(angle, 0, 1e-9);
    ASSERT_NEAR(speed, 0, 1e-6);
  });
}

// The second harmonic of amplitude imbalance, at Ω = 2 P ω_m near the loop's own frequency:
//   H(jΩ) = (2ζω_n jΩ + ω_n²)/(ω_n² − Ω² + 2ζω_n jΩ) of the angle, jΩ ω_n²/(…) of the speed.
TEST(Resolver, TheLoopFiltersTheErrorAsASecondOrderLoopDoes) {
  const ResolverParameters p{.pole_pairs = 4, .amplitude_error = 0.004, .bandwidth = 100};
  const double w = 2 * pi * 100, omega_m = 70, harmonic = 2 * 4 * omega_m;
  std::complex<double> angle_sum{}, speed_sum{};
  double n = 0;
  visit_errors(p, omega_m, [&](double theta, double angle, double speed) {
    const std::complex<double> turn = std::polar(1.0, -2 * theta);
    angle_sum += angle * turn;
    speed_sum += speed * turn;
    n += 0.5;
  });
  const std::complex<double> s{0, harmonic};
  const std::complex<double> below = w * w + s * s + std::numbers::sqrt2 * w * s;
  const std::complex<double> input{0, -0.002};  // 0.002 sin 2θ
  const std::complex<double> angle = input * (std::numbers::sqrt2 * w * s + w * w) / below;
  const std::complex<double> speed = input * s * w * w / below;
  // A turn of the signals is not a whole number of periods: to 2 %.
  EXPECT_LT(std::abs(angle_sum / n - angle), 0.02 * std::abs(angle));
  EXPECT_LT(std::abs(speed_sum / n - speed), 0.02 * std::abs(speed));
}

TEST(Resolver, IsReadInPlaceOfTheTrueShaft) {
  SensorParameters p;
  p.resolver = {.pole_pairs = 2, .sine_offset = 0.1};
  SensorModel model{p, {}};
  EXPECT_FALSE(model.is_ideal());
  model.begin(0, 0, 0, period_ns);
  Measurement<double> m;
  for (std::int64_t t = period_ns; t < 100'000'000; t += period_ns) {
    m = {.omega_m = 7, .theta_m = 0.0};
    model.step(m, 0, t, t);
  }
  EXPECT_NEAR(*m.theta_m, std::atan(0.1) / 2, 1e-9);
  EXPECT_NEAR(m.omega_m, 0, 1e-6);
  p.encoder.lines = 100;
  EXPECT_NE(p.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
