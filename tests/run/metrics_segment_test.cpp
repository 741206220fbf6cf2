// Metrics of event-exact runs: what the segments of known signals must give.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/run/metrics.hpp"

namespace sextant {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t ms = 1'000'000;

/// Sets the instant of a sample to a time that need not be whole nanoseconds.
MetricsSample at(double t_ns, MetricsSample s) {
  s.t_ns = std::int64_t(std::floor(t_ns));
  s.fraction_ns = t_ns - std::floor(t_ns);
  return s;
}

/// Instants from 0 to end_ns that include `corners` and lie between them at random.
std::vector<double> random_cuts(std::vector<double> corners, double end_ns, int cuts, unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> anywhere{0, end_ns};
  for (int k = 0; k < cuts; ++k) corners.push_back(anywhere(random));
  corners.push_back(0);
  corners.push_back(end_ns);
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// Feeds signal(t_ns) between consecutive instants.
template <class Signal>
MetricList run(const MetricsParameters& parameters, const std::vector<double>& instants, Signal signal) {
  MetricsAccumulator accumulator{parameters};
  for (std::size_t k = 1; k < instants.size(); ++k) {
    accumulator.add_segment(at(instants[k - 1], signal(instants[k - 1])),
                            at(instants[k], signal(instants[k])));
  }
  return accumulator.metrics();
}

TEST(MetricsSegments, ATriangleHasItsAnalyticRippleHoweverItIsCut) {
  constexpr double amplitude = 0.459;
  constexpr double bias = -0.1;
  constexpr double quarter_ns = 12'345.678;
  std::vector<double> corners;
  for (int k = 1; k < 400; k += 2) corners.push_back(k * quarter_ns);
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto m = run({}, random_cuts(corners, 400 * quarter_ns, 3000, seed), [](double t) {
      const double phase = t / quarter_ns;
      const double triangle = 2 / pi * std::asin(std::sin(pi / 2 * phase));
      return MetricsSample{.torque_reference = 15, .torque = 15 + bias + amplitude * triangle};
    });
    EXPECT_NEAR(m[Metric::torque_ripple_pp], 2 * amplitude, 1e-7);
    EXPECT_NEAR(m[Metric::torque_ripple_rms], amplitude / std::numbers::sqrt3, 1e-7);
    EXPECT_NEAR(m[Metric::torque_bias], bias, 1e-7);
    EXPECT_NEAR(m[Metric::torque_error_rms], std::sqrt(amplitude * amplitude / 3 + bias * bias), 1e-7);
    EXPECT_NEAR(m[Metric::torque_error_max], amplitude - bias, 1e-7);
  }
}

TEST(MetricsSegments, WeighByTheirDurationDownToFractionsOfANanosecond) {
  MetricsAccumulator accumulator{{}};
  const MetricsSample low{.torque = 1};
  const MetricsSample high{.torque = 3};
  for (int k = 0; k < 1000; ++k) {
    accumulator.add_segment(at(1.2 * k, low), at(1.2 * k + 0.3, low));
    accumulator.add_segment(at(1.2 * k + 0.3, high), at(1.2 * k + 1.2, high));
  }
  EXPECT_NEAR(accumulator.metrics()[Metric::torque_bias], 2.5, 1e-9);
  EXPECT_NEAR(accumulator.metrics()[Metric::torque_ripple_rms], std::sqrt(0.75), 1e-9);
}

TEST(MetricsSegments, KeepFractionsOfANanosecondAtTheEndOfALongRun) {
  MetricsAccumulator accumulator{{}};
  constexpr std::int64_t late_ns = 600'000'000'000;
  const auto low = [](double fraction) {
    return MetricsSample{.t_ns = late_ns, .torque = 1, .fraction_ns = fraction};
  };
  accumulator.add_segment(low(0), low(0.25));
  accumulator.add_segment({.t_ns = late_ns, .torque = 5, .fraction_ns = 0.25},
                          {.t_ns = late_ns + 1, .torque = 5});
  EXPECT_NEAR(accumulator.metrics()[Metric::torque_bias], 4, 1e-12);
}

TEST(MetricsSegments, TheWindowCutsASegmentWhereItsEndsLie) {
  // 1 N·m and 0.1 Wb each millisecond, up or down.
  for (const double slope : {1.0, -1.0}) {
    for (const unsigned seed : {4U, 5U}) {
      SCOPED_TRACE("slope " + std::to_string(slope) + ", seed " + std::to_string(seed));
      const auto line = [slope](double t) {
        return MetricsSample{.torque = slope * t / ms, .psi_s = {0, 1 + slope * 0.1 * t / ms}};
      };
      for (const int cuts : {0, 1, 50}) {
        const auto m = run({.from_ns = 2 * ms, .to_ns = 5 * ms}, random_cuts({}, 10 * ms, cuts, seed), line);
        EXPECT_NEAR(m[Metric::torque_ripple_pp], 3, 1e-9);
        EXPECT_NEAR(m[Metric::torque_bias], slope * 3.5, 1e-9);
        EXPECT_NEAR(m[Metric::torque_ripple_rms], 3 / std::sqrt(12.0), 1e-9);
        EXPECT_NEAR(m[Metric::torque_error_max], 5, 1e-9);
        EXPECT_NEAR(m[Metric::flux_min], slope > 0 ? 1.2 : 0.5, 1e-9);
        EXPECT_NEAR(m[Metric::flux_max], slope > 0 ? 1.5 : 0.8, 1e-9);
        EXPECT_NEAR(m[Metric::flux_mean], 1 + slope * 0.35, 1e-9);
      }
    }
  }
}

TEST(MetricsSegments, OutsideTheWindowThereIsOnlyThePeakCurrent) {
  const auto m = run({.from_ns = 20 * ms}, {0, 1e6, 2e6, 20e6}, [](double t) {
    return MetricsSample{.torque = 1, .i_s = {t == 1e6 ? -90.0 : 10.0, 0}};
  });
  EXPECT_EQ(m[Metric::peak_current], 90);
  EXPECT_TRUE(std::isnan(m[Metric::torque_bias]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_shaft]));
}

TEST(MetricsSegments, BothEndsCountForThePeakCurrent) {
  for (const bool at_the_end : {false, true}) {
    MetricsAccumulator accumulator{{}};
    accumulator.add_segment({.t_ns = 0, .i_s = {at_the_end ? 1.0 : 55.0, 0}},
                            {.t_ns = ms, .i_s = {at_the_end ? 55.0 : 1.0, 0}});
    EXPECT_EQ(accumulator.metrics()[Metric::peak_current], 55);
  }
}

TEST(MetricsSegments, ASegmentWithoutLengthHasNoWeight) {
  MetricsAccumulator accumulator{{}};
  accumulator.add_segment({.torque = 1}, {.t_ns = 5, .torque = 1});
  accumulator.add_segment({.t_ns = 5, .torque = 100}, {.t_ns = 5, .torque = -100});
  accumulator.add_segment({.t_ns = 5, .torque = 1}, {.t_ns = 10, .torque = 1});
  EXPECT_EQ(accumulator.metrics()[Metric::torque_ripple_pp], 0);
  EXPECT_EQ(accumulator.metrics()[Metric::torque_bias], 1);
}

TEST(MetricsSegments, ThdIsThatOfTheCurrentInTheFluxFrame) {
  // A triangle of 2 A on 20 A along the flux, which turns with the current.
  constexpr double quarter_ns = 10'000;
  std::vector<double> instants;
  for (int k = 0; k <= 400; ++k) instants.push_back(k * quarter_ns);
  const auto m = run({}, instants, [](double t) {
    const double triangle = 2 / pi * std::asin(std::sin(pi / 2 * t / quarter_ns));
    const SpaceVector<> axis = polar(1.0, 2 * pi * 50 * t * 1e-9);
    return MetricsSample{.psi_s = 1.1 * axis, .i_s = (20 + 2 * triangle) * axis};
  });
  EXPECT_NEAR(m[Metric::current_thd], 100 * 2 / std::numbers::sqrt3 / 20, 1e-9);
}

TEST(MetricsSegments, ResponseTimeIsThatOfTheLineBetweenTheInstants) {
  // The reference jumps at 10 ms; the torque follows in a line of 2 ms from there.
  for (const double before : {0.0, 5.0, -20.0}) {
    for (const double after : {15.0, -15.0}) {
      for (const unsigned seed : {6U, 7U}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        MetricsAccumulator accumulator{{.step_ns = 10 * ms}};
        const auto instants = random_cuts({10e6, 12e6}, 20e6, 30, seed);
        const auto sample = [=](double t, bool stepped) {
          const double share = std::clamp((t - 10e6) / 2e6, 0.0, 1.0);
          return at(
              t, {.torque_reference = stepped ? after : before, .torque = before + share * (after - before)});
        };
        for (std::size_t k = 1; k < instants.size(); ++k) {
          const bool stepped = instants[k - 1] >= 10e6;
          accumulator.add_segment(sample(instants[k - 1], stepped), sample(instants[k], stepped));
        }
        EXPECT_NEAR(accumulator.metrics()[Metric::response_time], 0.95 * 2, 1e-9);
      }
    }
  }
}

TEST(MetricsSegments, AReferenceThatDoesNotJumpIsNoStep) {
  for (const std::vector<double>& instants : {std::vector{0.0, 4e6, 17e6, 20e6}, std::vector{0.0, 20e6}}) {
    const auto m = run({.step_ns = 10 * ms}, instants, [](double t) {
      return MetricsSample{.torque_reference = 5 + t * 1e-6, .torque = 5 + t * 1e-6};
    });
    EXPECT_TRUE(std::isnan(m[Metric::response_time]));
  }
}

TEST(MetricsSegments, RoundingOfTheInstantBeforeTheStepLosesNoResponse) {
  for (const double rounding_ns : {-1e-6, 0.0, 1e-6}) {
    SCOPED_TRACE(rounding_ns);
    MetricsAccumulator accumulator{{.step_ns = 10 * ms}};
    accumulator.add_segment({.torque_reference = 5, .torque = 5},
                            at(10e6 + rounding_ns, {.torque_reference = 5, .torque = 5}));
    accumulator.add_segment({.t_ns = 10 * ms, .torque_reference = 25, .torque = 5},
                            {.t_ns = 12 * ms, .torque_reference = 25, .torque = 25});
    EXPECT_NEAR(accumulator.metrics()[Metric::response_time], 1.9, 1e-9);
  }
}

TEST(MetricsSegments, PulsesAndSwitchingCountInTheWindowPerSecondOfIt) {
  MetricsAccumulator accumulator{{.from_ns = 10 * ms, .to_ns = 30 * ms}};
  for (std::int64_t t = 0; t < 40 * ms; t += ms) {
    accumulator.commutate(t, switch_states[0]);
    accumulator.pulse(t + ms / 2);
    accumulator.add_segment({.t_ns = t}, {.t_ns = t + ms / 2});
    accumulator.commutate(t + ms / 2, switch_states[7]);
    accumulator.add_segment({.t_ns = t + ms / 2}, {.t_ns = t + ms});
  }
  EXPECT_NEAR(accumulator.metrics()[Metric::torque_pulse_frequency], 1000, 1e-9);
  EXPECT_NEAR(accumulator.metrics()[Metric::switching_frequency], 1000, 1e-9);
}

TEST(MetricsSegments, OfAnEventExactRunThePulsesAreThoseTold) {
  MetricsAccumulator accumulator{{}};
  accumulator.commutate(0, switch_states[0]);
  accumulator.add_segment({.t_ns = 0}, {.t_ns = 5 * ms});
  accumulator.commutate(5 * ms, switch_states[1]);
  accumulator.add_segment({.t_ns = 5 * ms}, {.t_ns = 10 * ms});
  EXPECT_EQ(accumulator.metrics()[Metric::torque_pulse_frequency], 0);
  EXPECT_NEAR(accumulator.metrics()[Metric::switching_frequency], 100.0 / 3, 1e-9);
}

/// Link power falls through zero; the meter reads its integral, 9 J lost in the windings, 3 J in the iron, 6
/// J of work and the rest in the field but for a leak.
MetricsSample metered(double t_ns, double leak = 0) {
  const double s = t_ns * 1e-9;
  const DriveEnergies e{.link = 100 * s - 75 * s * s, .copper = 9 * s, .shaft = 6 * s * s, .iron = 3 * s};
  return {.p_dc = 100 - 150 * s,
          .energies = {.link = e.link,
                       .copper = e.copper,
                       .shaft = e.shaft,
                       .field = e.link - e.copper - e.shaft - e.iron - leak * s,
                       .iron = e.iron}};
}

TEST(MetricsSegments, EnergiesAreTheDifferencesOfTheMeterInTheWindow) {
  for (const unsigned seed : {8U, 9U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const int cuts : {0, 40}) {
      const auto m = run({}, random_cuts({}, 1e9, cuts, seed), [](double t) { return metered(t); });
      EXPECT_NEAR(m[Metric::energy_from_link], 100.0 / 3, 1e-9);
      EXPECT_NEAR(m[Metric::energy_to_link], 25.0 / 3, 1e-9);
      EXPECT_NEAR(m[Metric::energy_shaft], 6, 1e-9);
      EXPECT_NEAR(m[Metric::energy_copper], 9, 1e-9);
      EXPECT_NEAR(m[Metric::energy_iron], 3, 1e-9);
      EXPECT_NEAR(m[Metric::energy_field], 25 - 9 - 3 - 6, 1e-9);
    }
    const auto half =
        run({.from_ns = 500 * ms}, random_cuts({0.5e9}, 1e9, 40, seed), [](double t) { return metered(t); });
    EXPECT_NEAR(half[Metric::energy_copper], 4.5, 1e-9);
    EXPECT_NEAR(half[Metric::energy_iron], 1.5, 1e-9);
    EXPECT_NEAR(half[Metric::energy_shaft], 4.5, 1e-9);
  }
}

TEST(MetricsSegments, WhatFlowsOneWayIsTheMetersReadingHoweverThePowerBends) {
  const auto m = run({}, {0, 1e9}, [](double t) {
    return MetricsSample{.p_dc = t == 0 ? 10.0 : 1.0, .energies = {.link = t * 1e-9 * 3}};
  });
  EXPECT_EQ(m[Metric::energy_from_link], 3);
  EXPECT_EQ(m[Metric::energy_to_link], 0);
}

TEST(MetricsSegments, TheBalanceIsThatOfTheWholeRun) {
  const std::vector<double> instants = random_cuts({}, 1e9, 40, 10);
  const MetricsParameters late{.from_ns = 900 * ms};
  const auto closed = run(late, instants, [](double t) { return metered(t); });
  EXPECT_NEAR(closed[Metric::energy_unaccounted], 0, 1e-12);
  const auto leaking = run(late, instants, [](double t) { return metered(t, 0.01); });
  EXPECT_NEAR(leaking[Metric::energy_unaccounted], 0.01 / (25 + 2 * 25.0 / 3 + 12 + 6 + 6.99), 1e-12);
  const auto nothing =
      run({}, {0, 1e9}, [](double) { return MetricsSample{.p_dc = 0, .energies = {0, 0, 0, 0, 0}}; });
  EXPECT_EQ(nothing[Metric::energy_unaccounted], 0);
}

TEST(MetricsSegments, SpeedErrorIsTheRmsOfTheLines) {
  const auto m = run({}, {0, 0.2e9, 1e9}, [](double t) {
    return MetricsSample{.omega_m = 40 + 6 * t * 1e-9, .speed_reference = 43};
  });
  EXPECT_NEAR(m[Metric::speed_error_rms], 6 / std::sqrt(12.0), 1e-12);
}

TEST(MetricsSegments, WhatIsUnknownSpoilsNoOtherMetric) {
  const auto m = run({}, {0, 1e6}, [](double) { return MetricsSample{.torque = 1, .omega_m = 2}; });
  EXPECT_TRUE(std::isnan(m[Metric::energy_from_link]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_to_link]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_copper]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_iron]));
  EXPECT_TRUE(std::isnan(m[Metric::speed_error_rms]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_shaft]));
  EXPECT_TRUE(std::isnan(m[Metric::energy_unaccounted]));
  EXPECT_EQ(m[Metric::torque_bias], 1);
}

TEST(MetricsSegments, AnEndThatIsNotFiniteSpoilsEveryMetric) {
  for (const bool at_the_end : {false, true}) {
    MetricsAccumulator accumulator{{}};
    accumulator.add_segment({.t_ns = 0}, {.t_ns = ms});
    const MetricsSample good{.t_ns = at_the_end ? ms : 2 * ms};
    const MetricsSample bad{.t_ns = at_the_end ? 2 * ms : ms, .torque = nan};
    accumulator.add_segment(at_the_end ? good : bad, at_the_end ? bad : good);
    accumulator.add_segment({.t_ns = 2 * ms}, {.t_ns = 3 * ms});
    const MetricList m = accumulator.metrics();
    for (const double v : m.values()) EXPECT_TRUE(std::isnan(v));
  }
}

}  // namespace
}  // namespace sextant
