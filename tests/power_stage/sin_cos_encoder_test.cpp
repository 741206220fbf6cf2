// Angle and speed of a sin/cos encoder: errors of its tracks against first-order closed forms, the speed
// against the mean slope over its window.
#include "sextant/power_stage/sin_cos_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sextant/power_stage/sensor_model.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::int64_t period_ns = 50'000;
constexpr double period_s = 50e-6;

/// Angle of the sines [rad], its error, and that of the speed of the shaft [rad/s], in 3000 samples.
void visit_errors(const SinCosEncoderParameters& p, double omega_m,
                  const std::function<void(double theta, double angle, double speed)>& visit) {
  SinCosEncoder encoder{p};
  encoder.begin(0.0, omega_m, 0, period_ns);
  for (std::int64_t n = 0; n < 3000; ++n) {
    const double theta_m = omega_m * double(n) * period_s;
    encoder.step(theta_m, n * period_ns);
    visit(p.periods * theta_m, p.periods * (encoder.theta() - theta_m), encoder.omega() - omega_m);
  }
}

/// Of the angle, at several turns of the sines a sample too; the speed is its difference over the window.
void expect_error(const SinCosEncoderParameters& p, const std::function<double(double)>& closed,
                  double tolerance) {
  for (const double omega_m : {-0.7, 3.1, 150.0, -4000.0}) {
    const double window_s = p.window_periods * period_s;
    visit_errors(p, omega_m, [&](double theta, double angle, double speed) {
      ASSERT_NEAR(angle, closed(theta), tolerance) << theta;
      const double before = closed(theta - p.periods * omega_m * window_s);
      ASSERT_NEAR(speed, (closed(theta) - before) / (p.periods * window_s),
                  2.0 * tolerance / (p.periods * window_s) + 1e-8 * std::abs(omega_m));
    });
  }
}

TEST(SinCosEncoder, AmplitudeImbalanceIsASecondHarmonic) {
  expect_error(
      {.periods = 1024, .amplitude_error = 0.01}, [](double x) { return 0.005 * std::sin(2 * x); }, 5e-5);
}

TEST(SinCosEncoder, QuadratureErrorIsASecondHarmonicAndAMean) {
  expect_error(
      {.periods = 512, .quadrature_error = 0.01, .window_periods = 4},
      [](double x) { return 0.005 * (std::cos(2 * x) - 1); }, 1e-4);
}

TEST(SinCosEncoder, OffsetsAreFirstHarmonics) {
  expect_error(
      {.periods = 2048, .sine_offset = 0.01, .cosine_offset = -0.02, .window_periods = 10},
      [](double x) { return 0.01 * std::cos(x) + 0.02 * std::sin(x); }, 4e-4);
}

TEST(SinCosEncoder, HasNoErrorWithoutOneOfItsTracks) {
  expect_error({.periods = 5000, .window_periods = 3}, [](double) { return 0.0; }, 1e-6);
}

// The sine, whose amplitude is sinc of half the angle by which the window turns the harmonic.
TEST(SinCosEncoder, TheWindowFiltersTheHarmonicInTheSpeed) {
  const SinCosEncoderParameters p{.periods = 100, .amplitude_error = 0.01, .window_periods = 20};
  const double omega_m = 11.3, x = p.periods * omega_m * p.window_periods * period_s;  // of half 2 θ
  const double amplitude = 0.005 / p.periods * 2.0 * p.periods * omega_m * std::abs(std::sin(x) / x);
  double most = 0.0;
  visit_errors(p, omega_m, [&most](double, double, double speed) { most = std::max(most, std::abs(speed)); });
  EXPECT_NEAR(most, amplitude, 0.01 * amplitude);
}

TEST(SinCosEncoder, QuantisationPutsNoMoreThanItsBoundOnTheSpeed) {
  for (const int bits : {4, 6, 8, 10, 12}) {
    const SinCosEncoderParameters p{.periods = 256, .bits = bits, .window_periods = 2};
    const double angle_bound = std::asin(2.0 * std::numbers::sqrt2 / (1 << bits));
    const double bound = 2.0 * angle_bound / (256 * 2 * period_s);
    double most = 0.0;
    for (const double omega_m : {0.05, 0.3, 7.0, 111.0, 500.0}) {
      visit_errors(p, omega_m, [&](double, double angle, double speed) {
        ASSERT_LE(std::abs(angle), angle_bound + 1e-9);
        most = std::max(most, std::abs(speed));
      });
    }
    EXPECT_LE(most, bound) << bits;
    EXPECT_GT(most, 0.5 * bound) << bits;
    EXPECT_NEAR(p.quantisation_error(period_s), bound, 1e-9 * bound);
  }
}

// The count of the sines survives reversals and speeds at which samples are many sines apart.
TEST(SinCosEncoder, TheCountLosesNoSine) {
  std::mt19937 random{25};
  SinCosEncoder encoder{{.periods = 1000, .amplitude_error = 0.1, .sine_offset = 0.1, .bits = 8}};
  double theta_m = 0.3, omega_m = 0.0;
  encoder.begin(theta_m, 0.0, 0, period_ns);
  for (std::int64_t n = 1; n < 20'000; ++n) {
    omega_m += std::uniform_real_distribution{-40.0, 40.0}(random);
    theta_m += omega_m * period_s;
    encoder.step(theta_m, n * period_ns);
    ASSERT_LT(std::abs(encoder.theta() - theta_m), 0.2 / 1000);
  }
}

TEST(SinCosEncoder, KnowsTheSpeedOfAShaftThatHasBeenTurning) {
  SinCosEncoder encoder{{.periods = 1024, .window_periods = 40}};
  encoder.begin(1.0, 75.0, 1'000'000, period_ns);
  encoder.step(1.0, 1'000'000);
  EXPECT_NEAR(encoder.omega(), 75.0, 1e-7);
}

TEST(SinCosEncoder, IsReadInPlaceOfTheTrueShaft) {
  SensorParameters p;
  p.sin_cos = {.periods = 4, .sine_offset = 0.1};
  EXPECT_EQ(p.validate(), nullptr);
  SensorModel model{p, {}};
  EXPECT_FALSE(model.is_ideal());
  model.begin(0, 0, 0, period_ns);
  Measurement<double> m{.omega_m = 7, .theta_m = 0.0};
  model.step(m, 0, 0, 0);
  EXPECT_NEAR(*m.theta_m, std::atan(0.1) / 4, 1e-12);
  EXPECT_NEAR(m.omega_m, 0, 1e-9);
  p.resolver.pole_pairs = 1;
  EXPECT_NE(p.validate(), nullptr);
  p.resolver.pole_pairs = 0;
  p.encoder.lines = 100;
  EXPECT_NE(p.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
