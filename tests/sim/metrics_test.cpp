#include "sextant/sim/metrics.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t period_ns = 25'000;
constexpr std::int64_t ms = 1'000'000;

double seconds(std::int64_t t_ns) {
  return double(t_ns) * 1e-9;
}

/// Feeds samples of signal(t_ns), one a control period, over [0, end_ns).
template <class Signal>
MetricList run(const MetricsParameters& parameters, std::int64_t end_ns, Signal signal) {
  MetricsAccumulator accumulator{parameters};
  for (std::int64_t t = 0; t < end_ns; t += period_ns) {
    MetricsSample s = signal(t);
    s.t_ns = t;
    accumulator.add(s);
  }
  return accumulator.metrics();
}

TEST(MetricsAccumulator, SineRippleHasItsAnalyticPeakRmsAndBias) {
  constexpr double amplitude = 2;
  constexpr double bias = -0.5;
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double ripple = amplitude * std::sin(2 * pi * 100 * seconds(t));
    return MetricsSample{.torque_reference = 15, .torque = 15 + bias + ripple};
  });
  EXPECT_NEAR(m[Metric::torque_ripple_pp], 2 * amplitude, 1e-9);
  EXPECT_NEAR(m[Metric::torque_ripple_rms], amplitude / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(m[Metric::torque_bias], bias, 1e-9);
}

TEST(MetricsAccumulator, AMovingReferenceIsNotRipple) {
  const auto m = run({}, 100 * ms, [](std::int64_t t) {
    const double reference = 15 * std::sin(2 * pi * 10 * seconds(t));
    return MetricsSample{.torque_reference = reference, .torque = reference - 0.25};
  });
  EXPECT_NEAR(m[Metric::torque_ripple_pp], 0, 1e-12);
  EXPECT_NEAR(m[Metric::torque_ripple_rms], 0, 1e-12);
  EXPECT_NEAR(m[Metric::torque_bias], -0.25, 1e-12);
}

TEST(MetricsAccumulator, WindowIncludesBothEndsAndNothingElse) {
  const auto m = run({.from_ns = 10 * ms, .to_ns = 20 * ms}, 40 * ms, [](std::int64_t t) {
    const bool inside = t >= 10 * ms && t <= 20 * ms;
    const bool at_an_end = t == 10 * ms || t == 20 * ms;
    return MetricsSample{.torque = inside ? (at_an_end ? 3.0 : 1.0) : 1000.0,
                         .psi_s = {inside ? (at_an_end ? 0.9 : 1.1) : 50.0, 0}};
  });
  EXPECT_EQ(m[Metric::torque_ripple_pp], 2);
  EXPECT_EQ(m[Metric::flux_min], 0.9);
  EXPECT_EQ(m[Metric::flux_max], 1.1);
  EXPECT_NEAR(m[Metric::flux_mean], 1.1 - 2 * 0.2 / 401, 1e-12);
}

TEST(MetricsAccumulator, RippleOnALargeOffsetDoesNotCancel) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    return MetricsSample{.torque = 1e9 + (t / period_ns % 2 == 0 ? 1.0 : -1.0)};
  });
  EXPECT_NEAR(m[Metric::torque_ripple_rms], 1, 1e-6);
}

TEST(MetricsAccumulator, FluxIsTheMagnitudeOfTheVector) {
  const auto m = run({}, 20 * ms, [](std::int64_t t) {
    return MetricsSample{
        .psi_s = polar(1.1 + 0.01 * std::sin(2 * pi * 50 * seconds(t)), 2 * pi * 50 * seconds(t))};
  });
  EXPECT_NEAR(m[Metric::flux_mean], 1.1, 1e-9);
  EXPECT_NEAR(m[Metric::flux_min], 1.09, 1e-9);
  EXPECT_NEAR(m[Metric::flux_max], 1.11, 1e-9);
}

TEST(MetricsAccumulator, FirstOrderStepTakesThreeTimeConstants) {
  constexpr double tau_s = 1e-3;
  for (const double before : {0.0, 5.0, -20.0}) {
    for (const double after : {15.0, -15.0}) {
      SCOPED_TRACE(std::to_string(before) + " to " + std::to_string(after));
      const auto m = run({.step_ns = 10 * ms}, 50 * ms, [=](std::int64_t t) {
        const double since = seconds(t - 10 * ms);
        const bool stepped = t >= 10 * ms;
        return MetricsSample{
            .torque_reference = stepped ? after : before,
            .torque = stepped ? after + (before - after) * std::exp(-since / tau_s) : before};
      });
      EXPECT_GE(m[Metric::response_time], 1e3 * tau_s * std::log(20.0));
      EXPECT_LE(m[Metric::response_time], 1e3 * tau_s * std::log(20.0) + 1e-6 * double(period_ns));
    }
  }
}

TEST(MetricsAccumulator, StepAtTheBeginningStartsFromZero) {
  const auto m = run({.step_ns = 0}, 10 * ms, [](std::int64_t t) {
    return MetricsSample{.torque_reference = 20, .torque = t < 2 * ms ? 18.9 : 19.0};
  });
  EXPECT_DOUBLE_EQ(m[Metric::response_time], 2);
}

TEST(MetricsAccumulator, ResponseTimeIsAbsentWithoutAResponseAStepOrASpecifiedInstant) {
  const auto never = run({.step_ns = 1 * ms}, 10 * ms, [](std::int64_t t) {
    return MetricsSample{.torque_reference = t < 1 * ms ? 0.0 : 10.0, .torque = 9.4};
  });
  EXPECT_TRUE(std::isnan(never[Metric::response_time]));
  const auto no_step = run({.step_ns = 1 * ms}, 10 * ms,
                           [](std::int64_t) { return MetricsSample{.torque_reference = 10, .torque = 10}; });
  EXPECT_TRUE(std::isnan(no_step[Metric::response_time]));
  const auto none = run({}, 10 * ms, [](std::int64_t) { return MetricsSample{.torque_reference = 10}; });
  EXPECT_TRUE(std::isnan(none[Metric::response_time]));
}

TEST(MetricsAccumulator, SixStepSwitchesEachDeviceOncePerFundamentalPeriod) {
  constexpr double f = 50;
  const auto m = run({}, 1000 * ms + 1, [](std::int64_t t) {
    const auto vector = static_cast<std::size_t>(std::floor(6 * f * (seconds(t) + 1e-9))) % 6 + 1;
    return MetricsSample{.switch_state = switch_states[vector]};
  });
  EXPECT_NEAR(m[Metric::switching_frequency], f, 0.5);
}

TEST(MetricsAccumulator, SwitchingEdgesBetweenSamplesCount) {
  MetricsAccumulator accumulator{{}};
  for (std::int64_t t = 0; t <= 100 * period_ns; t += period_ns) {
    accumulator.add({.t_ns = t, .switch_state = switch_states[0]});
    if (t == 100 * period_ns) break;
    for (const std::size_t v : {1U, 2U, 7U, 2U, 1U}) accumulator.commutate(t + 5'000, switch_states[v]);
  }
  EXPECT_NEAR(accumulator.metrics()[Metric::switching_frequency], 1e9 / double(period_ns), 1e-6);
}

TEST(MetricsAccumulator, SwitchingOutsideTheWindowDoesNotCount) {
  const auto m = run({.from_ns = 10 * ms, .to_ns = 20 * ms}, 30 * ms, [](std::int64_t t) {
    const bool inside = t >= 10 * ms && t <= 20 * ms;
    return MetricsSample{.switch_state =
                             inside ? switch_states[1] : switch_states[t / period_ns % 2 == 0 ? 7 : 0]};
  });
  EXPECT_EQ(m[Metric::switching_frequency], 0);
}

TEST(MetricsAccumulator, TurnOnOutOfGatesOffCountsAndTurnOffDoesNot) {
  MetricsAccumulator accumulator{{}};
  accumulator.add({.t_ns = 0, .switch_state = gates_off});
  accumulator.add({.t_ns = 500 * ms, .switch_state = switch_states[7]});
  accumulator.add({.t_ns = 1000 * ms, .switch_state = gates_off});
  EXPECT_DOUBLE_EQ(accumulator.metrics()[Metric::switching_frequency], 1);
}

TEST(MetricsAccumulator, ErrorRmsAndMaximumIncludeTheBias) {
  const auto m = run({}, 100 * ms, [](std::int64_t t) {
    return MetricsSample{.torque_reference = 10, .torque = t / period_ns % 2 == 0 ? 6.0 : 8.0};
  });
  EXPECT_NEAR(m[Metric::torque_error_rms], std::sqrt((16.0 + 4.0) / 2), 1e-12);
  EXPECT_EQ(m[Metric::torque_error_max], 4);
}

TEST(MetricsAccumulator, APulseIsAZeroVectorLeftForAnActiveOne) {
  MetricsAccumulator accumulator{{}};
  std::int64_t t = 0;
  // Begin at 0-1, 7-3 and 0-6; gates that were off begin no pulse.
  for (const std::size_t v : {0U, 1U, 2U, 7U, 3U, 0U, 7U, 0U, 6U}) {
    accumulator.add({.t_ns = t, .switch_state = switch_states[v]});
    t += 100 * ms;
  }
  accumulator.add({.t_ns = t, .switch_state = gates_off});
  accumulator.add({.t_ns = 1000 * ms, .switch_state = switch_states[4]});
  EXPECT_DOUBLE_EQ(accumulator.metrics()[Metric::torque_pulse_frequency], 3);
  EXPECT_TRUE(std::isnan(accumulator.metrics()[Metric::dwell_limited]));
}

TEST(MetricsAccumulator, EnergiesAreThoseOfTheControlPeriodsInTheWindow) {
  const auto m = run({.from_ns = 100 * ms, .to_ns = 300 * ms}, 1000 * ms, [](std::int64_t t) {
    // The power of the period that ended: a quarter of the window feeds back.
    return MetricsSample{.torque = 2,
                         .omega_m = 10 * seconds(t),
                         .p_dc = t <= 100 * ms ? 1e6 : (t <= 250 * ms ? 400.0 : -100.0),
                         .p_copper = 30};
  });
  EXPECT_NEAR(m[Metric::energy_from_link], 400 * 0.15, 1e-9);
  EXPECT_NEAR(m[Metric::energy_to_link], 100 * 0.05, 1e-9);
  EXPECT_NEAR(m[Metric::energy_shaft], 2 * 10 * 0.5 * (0.3 * 0.3 - 0.1 * 0.1), 1e-9);
  EXPECT_NEAR(m[Metric::energy_copper], 30 * 0.2, 1e-9);
}

TEST(MetricsAccumulator, WhatIsUnknownSpoilsNoOtherMetric) {
  const auto m = run({}, 10 * ms, [](std::int64_t) { return MetricsSample{.torque = 2, .omega_m = 3}; });
  EXPECT_TRUE(std::isnan(m[Metric::energy_from_link]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_copper]));
  EXPECT_TRUE(std::isnan(m[Metric::speed_error_rms]));
  EXPECT_NEAR(m[Metric::energy_shaft], 6 * (0.01 - 25e-6), 1e-12);
}

TEST(MetricsAccumulator, SpeedErrorIsTheRmsAboutTheReference) {
  const auto m = run({}, 100 * ms, [](std::int64_t t) {
    return MetricsSample{.omega_m = 50 + (t / period_ns % 2 == 0 ? 1.0 : -7.0), .speed_reference = 50};
  });
  EXPECT_NEAR(m[Metric::speed_error_rms], 5, 1e-12);
}

TEST(MetricsAccumulator, PeakCurrentIsThatOfAnyPhaseOverTheWholeRun) {
  for (const double theta : {0.0, pi, 2 * pi / 3, -pi / 3, 4 * pi / 3}) {
    SCOPED_TRACE(theta);
    const auto m = run({.from_ns = 20 * ms}, 30 * ms, [theta](std::int64_t t) {
      return MetricsSample{.i_s = polar(t == 5 * ms ? 90.0 : 10.0, theta)};
    });
    EXPECT_NEAR(m[Metric::peak_current], 90, 1e-9);
  }
}

TEST(MetricsAccumulator, ThdOfKnownHarmonicsIsExact) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double theta = 2 * pi * 50 * seconds(t);
    return MetricsSample{
        .psi_s = polar(1.1, theta),
        .i_s = polar(20.0, theta + 0.7) + polar(3.0, -5 * theta) + polar(4.0, 7 * theta + 1)};
  });
  EXPECT_NEAR(m[Metric::current_thd], 100 * 5.0 / 20.0, 1e-9);
}

TEST(MetricsAccumulator, ThdOfASixStepWaveIsThatOfItsFourierSeries) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double theta = 2 * pi * 50 * (seconds(t) + 0.5e-9 * double(period_ns));
    return MetricsSample{.psi_s = polar(1.0, theta),
                         .i_s = polar(10.0, std::floor(theta / (pi / 3)) * pi / 3)};
  });
  // Quasi-square wave: I_1/I_rms = 3/π.
  EXPECT_NEAR(m[Metric::current_thd], 100 * std::sqrt(pi * pi / 9 - 1), 0.05);
}

TEST(MetricsAccumulator, ASineAtChangingSpeedHasNoThd) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double theta = 2 * pi * (1 + 40 * seconds(t)) * seconds(t);
    return MetricsSample{.psi_s = polar(1.1, theta), .i_s = polar(20.0, theta + 0.7)};
  });
  EXPECT_NEAR(m[Metric::current_thd], 0, 1e-9);
}

TEST(MetricsAccumulator, ThdMatchesItsDefinitionForRandomCurrent) {
  for (const unsigned seed : {5U, 6U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random{seed};
    std::normal_distribution<double> noise{0, 3};
    SpaceVector<> sum{};
    double sum_of_squares = 0;
    constexpr int n = 4000;
    MetricsAccumulator accumulator{{}};
    for (int k = 0; k < n; ++k) {
      const double theta = noise(random);
      const SpaceVector<> in_flux_frame{20 + noise(random), 5 + noise(random)};
      const SpaceVector<> axis = polar(1.0, theta);
      accumulator.add({.t_ns = k * period_ns,
                       .psi_s = 1.1 * axis,
                       .i_s = in_flux_frame.alpha * axis + in_flux_frame.beta * rotate_90(axis)});
      sum += in_flux_frame;
      sum_of_squares += dot(in_flux_frame, in_flux_frame);
    }
    const SpaceVector<> mean = (1.0 / n) * sum;
    const double thd = std::sqrt(sum_of_squares / n - dot(mean, mean)) / magnitude(mean);
    EXPECT_NEAR(accumulator.metrics()[Metric::current_thd], 100 * thd, 1e-8);
  }
}

TEST(MetricsAccumulator, WithoutFluxOrCurrentThereIsNoThdAndNoCrash) {
  const auto m = run({}, 1 * ms, [](std::int64_t) { return MetricsSample{}; });
  EXPECT_TRUE(std::isnan(m[Metric::current_thd]));
  EXPECT_EQ(m[Metric::peak_current], 0);
  EXPECT_EQ(m[Metric::flux_mean], 0);
}

TEST(MetricsAccumulator, IsEmptyWithoutSamplesAndOutsideTheWindow) {
  const MetricList none = MetricsAccumulator{{}}.metrics();
  for (const double v : none.values()) EXPECT_TRUE(std::isnan(v));
  const auto m = run({.from_ns = 100 * ms, .to_ns = 200 * ms}, 10 * ms,
                     [](std::int64_t) { return MetricsSample{.torque = 1, .i_s = {7, 0}}; });
  EXPECT_TRUE(std::isnan(m[Metric::torque_bias]));
  EXPECT_TRUE(std::isnan(m[Metric::switching_frequency]));
  EXPECT_EQ(m[Metric::peak_current], 7);
}

TEST(MetricsAccumulator, OneSampleThatIsNotFiniteSpoilsEveryMetric) {
  const MetricsSample broken[] = {
      {.torque_reference = nan}, {.torque = nan},   {.psi_s = {nan, 0}},
      {.psi_s = {0, nan}},       {.i_s = {nan, 0}}, {.i_s = {0, std::numeric_limits<double>::infinity()}},
      {.omega_m = nan}};
  for (const MetricsSample& b : broken) {
    const auto m = run({.step_ns = 1 * ms}, 10 * ms, [&b](std::int64_t t) {
      if (t == 5 * ms) return b;
      return MetricsSample{.torque_reference = t < 1 * ms ? 0.0 : 1.0, .torque = 1, .i_s = {1, 0}};
    });
    for (const double v : m.values()) EXPECT_TRUE(std::isnan(v));
  }
}

TEST(MetricsParameters, RefusesAWindowThatIsNone) {
  EXPECT_EQ((MetricsParameters{}.validate()), nullptr);
  EXPECT_NE((MetricsParameters{.from_ns = -1}.validate()), nullptr);
  EXPECT_NE((MetricsParameters{.from_ns = 5, .to_ns = 5}.validate()), nullptr);
  EXPECT_NE((MetricsParameters{.step_ns = -1}.validate()), nullptr);
  EXPECT_THROW((MetricsAccumulator{{.from_ns = 5, .to_ns = 4}}), std::runtime_error);
}

}  // namespace
}  // namespace sextant
