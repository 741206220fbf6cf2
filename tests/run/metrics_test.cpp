#include "sextant/run/metrics.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
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

/// Feeds signal(t_ns) from control period to control period, over [0, end_ns]; a reference holds in between.
template <class Signal>
MetricList run(const MetricsParameters& parameters, std::int64_t end_ns, Signal signal) {
  MetricsAccumulator accumulator{parameters};
  MetricsSample before = signal(std::int64_t{0});
  for (std::int64_t t = period_ns; t <= end_ns; t += period_ns) {
    MetricsSample after = signal(t);
    after.t_ns = t;
    const double reference = after.torque_reference;
    after.torque_reference = before.torque_reference;
    accumulator.add_segment(before, after);
    before = after;
    before.torque_reference = reference;
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
  EXPECT_NEAR(m[Metric::torque_ripple_rms], amplitude / std::numbers::sqrt2, 1e-4);
  EXPECT_NEAR(m[Metric::torque_bias], bias, 1e-9);
}

TEST(MetricsAccumulator, RippleOnALargeOffsetDoesNotCancel) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    return MetricsSample{.torque = 1e9 + (t / period_ns % 2 == 0 ? 1.0 : -1.0)};
  });
  EXPECT_NEAR(m[Metric::torque_ripple_rms], 1 / std::numbers::sqrt3, 1e-6);
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
      EXPECT_NEAR(m[Metric::response_time], 1e3 * tau_s * std::log(20.0), 1e-3);
    }
  }
}

TEST(MetricsAccumulator, StepAtTheBeginningStartsFromZero) {
  const auto m = run({.step_ns = 0}, 10 * ms, [](std::int64_t t) {
    return MetricsSample{.torque_reference = 20, .torque = t < 2 * ms ? 18.9 : 19.0};
  });
  EXPECT_NEAR(m[Metric::response_time], 2, 1e-9);
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
  MetricsAccumulator accumulator{{}};
  for (int k = 0; k < 6 * 50; ++k) {
    const auto t = std::int64_t(double(k) * 1e9 / (6 * f));
    accumulator.commutate(t, switch_states[std::size_t(k) % 6 + 1]);
    accumulator.add_segment({.t_ns = t}, {.t_ns = std::int64_t(double(k + 1) * 1e9 / (6 * f))});
  }
  const MetricList m = accumulator.metrics();
  EXPECT_NEAR(m[Metric::switching_frequency], f, 0.5);
}

TEST(MetricsAccumulator, TurnOnOutOfGatesOffCountsAndTurnOffDoesNot) {
  MetricsAccumulator accumulator{{}};
  accumulator.commutate(0, gates_off);
  accumulator.add_segment({.t_ns = 0}, {.t_ns = 500 * ms});
  accumulator.commutate(500 * ms, switch_states[7]);
  accumulator.add_segment({.t_ns = 500 * ms}, {.t_ns = 1000 * ms});
  accumulator.commutate(1000 * ms, gates_off);
  EXPECT_DOUBLE_EQ(accumulator.metrics()[Metric::switching_frequency], 1);
}

TEST(MetricsAccumulator, ErrorRmsAndMaximumIncludeTheBias) {
  const auto m = run({}, 100 * ms, [](std::int64_t t) {
    return MetricsSample{.torque_reference = 10, .torque = t / period_ns % 2 == 0 ? 6.0 : 8.0};
  });
  EXPECT_NEAR(m[Metric::torque_error_rms], std::sqrt(9 + 1.0 / 3), 1e-12);
  EXPECT_EQ(m[Metric::torque_error_max], 4);
}

TEST(MetricsAccumulator, SpeedErrorIsTheRmsAboutTheReference) {
  const auto m = run({}, 100 * ms, [](std::int64_t t) {
    return MetricsSample{.omega_m = 50 + (t / period_ns % 2 == 0 ? 1.0 : -7.0), .speed_reference = 50};
  });
  EXPECT_NEAR(m[Metric::speed_error_rms], std::sqrt((1 - 7 + 49) / 3.0), 1e-12);
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
  EXPECT_NEAR(m[Metric::current_thd], 100 * 5.0 / 20.0, 0.01);
}

TEST(MetricsAccumulator, ThdOfASixStepWaveIsThatOfItsFourierSeries) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double theta = 2 * pi * 50 * (seconds(t) + 0.5e-9 * double(period_ns));
    return MetricsSample{.psi_s = polar(1.0, theta),
                         .i_s = polar(10.0, std::floor(theta / (pi / 3)) * pi / 3)};
  });
  // Quasi-square wave: I_1/I_rms = 3/π. Lines between the samples make its six edges a sample long.
  EXPECT_NEAR(m[Metric::current_thd], 100 * std::sqrt(pi * pi / 9 - 1), 0.3);
}

TEST(MetricsAccumulator, ASineAtChangingSpeedHasNoThd) {
  const auto m = run({}, 1000 * ms, [](std::int64_t t) {
    const double theta = 2 * pi * (1 + 40 * seconds(t)) * seconds(t);
    return MetricsSample{.psi_s = polar(1.1, theta), .i_s = polar(20.0, theta + 0.7)};
  });
  EXPECT_NEAR(m[Metric::current_thd], 0, 1e-9);
}

/// 20 A and a fifth harmonic of 3 A, the torque asked for and the switching state by the time.
template <class Reference, class State>
double thd(const MetricsParameters& window, Reference reference, State state, double growth = 0) {
  MetricsAccumulator accumulator{window};
  const auto at = [&](std::int64_t t, std::int64_t held) {
    const double theta = 2 * pi * 50 * seconds(t);
    const double fundamental = 20 * (1 + growth * seconds(t));
    return MetricsSample{.t_ns = t,
                         .torque_reference = reference(held),
                         .psi_s = polar(1.1, theta),
                         .i_s = polar(fundamental, theta + 0.7) + polar(3.0, -5 * theta)};
  };
  for (std::int64_t t = 0; t < 1000 * ms; t += period_ns) {
    accumulator.commutate(t, state(t));
    accumulator.add_segment(at(t, t), at(t + period_ns, t));
  }
  return accumulator.metrics()[Metric::current_thd];
}

TEST(MetricsAccumulator, ThereIsAThdOnlyWhereTheTorqueStandsStill) {
  const auto steady = [](std::int64_t) { return 15.0; };
  const auto driven = [](std::int64_t) { return switch_states[1]; };
  const MetricsParameters window{.from_ns = 100 * ms};
  EXPECT_NEAR(thd(window, steady, driven), 15, 0.01);
  EXPECT_TRUE(std::isnan(thd({}, steady, driven))) << "the torque has only just been asked for";
  for (const std::int64_t step : {85 * ms, 100 * ms, 500 * ms, 999 * ms}) {
    SCOPED_TRACE(step);
    const auto stepped = [step](std::int64_t t) { return t < step ? 15.0 : -15.0; };
    EXPECT_TRUE(std::isnan(thd(window, stepped, driven)));
  }
  const auto early = [](std::int64_t t) { return t < 70 * ms ? 15.0 : -15.0; };
  EXPECT_NEAR(thd(window, early, driven), 15, 0.01) << "the current has settled";
  const auto sine = [](std::int64_t t) { return 15 * std::sin(2 * pi * seconds(t)); };
  EXPECT_TRUE(std::isnan(thd(window, sine, driven)));
  const auto ramp = [](std::int64_t t) { return 15 + 1e-3 * seconds(t); };
  EXPECT_TRUE(std::isnan(thd(window, ramp, driven))) << "however slowly it moves";
}

TEST(MetricsAccumulator, ThereIsNoThdWhereTheDriveHasTrippedOrTheFundamentalGrows) {
  const auto steady = [](std::int64_t) { return 15.0; };
  const MetricsParameters window{.from_ns = 100 * ms};
  const auto trips = [](std::int64_t t) { return t < 900 * ms ? switch_states[1] : gates_off; };
  EXPECT_TRUE(std::isnan(thd(window, steady, trips)));
  const auto driven = [](std::int64_t) { return switch_states[1]; };
  EXPECT_TRUE(std::isnan(thd(window, steady, driven, 1.0)));
}

TEST(MetricsAccumulator, WithoutAComparatorThereIsNoFrequencyOfItsPulses) {
  MetricsAccumulator accumulator{{}};
  accumulator.has_no_pulses();
  accumulator.add_segment({.t_ns = 0}, {.t_ns = ms});
  EXPECT_TRUE(std::isnan(accumulator.metrics()[Metric::torque_pulse_frequency]));
  EXPECT_EQ(accumulator.metrics()[Metric::switching_frequency], 0);
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
