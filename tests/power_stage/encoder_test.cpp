#include "sextant/power_stage/encoder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 25'000;
constexpr double period_s = 25e-6;

double edge_angle(const EncoderParameters& p) {
  return 2.0 * std::numbers::pi / (4.0 * p.lines);
}

TEST(Encoder, CountsEveryEdgeInBothDirections) {
  constexpr unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> turn{-0.4, 0.4};
  const EncoderParameters p{.lines = 512};
  const double edge = edge_angle(p);
  Encoder encoder{p};
  double theta = 0.3;
  for (int n = 0; n < 50'000; ++n) {
    theta += turn(random);
    encoder.step(theta, n * period_ns);
    // The edges are whole; the reading lags by less than one of them.
    ASSERT_NEAR(std::remainder(encoder.theta(), edge), 0.0, 1e-9);
    ASSERT_GT(theta - encoder.theta(), -1e-9);
    ASSERT_LT(theta - encoder.theta(), edge + 1e-9);
  }
}

TEST(Encoder, TheCountedSpeedIsWithinOneEdgeOfTheWindowAndExactInTheMean) {
  for (const int window : {1, 7, 40, 512}) {
    for (const double omega : {50.0, -133.3, 0.7}) {
      SCOPED_TRACE(testing::Message() << window << " periods at " << omega << " rad/s");
      const EncoderParameters p{.lines = 1024, .speed = EncoderSpeed::count, .window_periods = window};
      const double resolution = edge_angle(p) / (window * period_s);
      Encoder encoder{p};
      double mean = 0;
      const int n = 40'000;
      for (int k = 0; k <= n + window; ++k) {
        encoder.step(omega * k * period_s, k * period_ns);
        if (k < window) continue;
        EXPECT_LE(std::abs(encoder.omega() - omega), resolution * (1 + 1e-9));
        const double edges = encoder.omega() / resolution;
        EXPECT_NEAR(edges, std::round(edges), 1e-6);
        if (k > window) mean += encoder.omega() / n;
      }
      // All but the first and the last window's edges are counted equally often.
      EXPECT_NEAR(mean, omega, 2.0 * edge_angle(p) / (n * period_s) * window);
    }
  }
}

TEST(Encoder, TheSpeedByPeriodIsExactAtConstantSpeed) {
  for (const int window : {1, 40}) {
    // At the last ones an edge comes more rarely than a window: 98 and 245 periods apart.
    for (const double omega : {120.0, -30.0, 0.627, -0.25}) {
      SCOPED_TRACE(testing::Message() << window << " periods at " << omega << " rad/s");
      const EncoderParameters p{.lines = 1024, .speed = EncoderSpeed::period, .window_periods = window};
      Encoder encoder{p};
      for (int k = 0; k <= 8'000; ++k) {
        encoder.step(0.1 + omega * k * period_s, k * period_ns);
        if (encoder.omega() == 0.0 && k < 1'000) continue;  // not yet two edges
        // Instants of edges are whole nanoseconds; without a new edge the bound is later than the estimate.
        const double between = std::max(edge_angle(p) / std::abs(omega), window * period_s) - period_s;
        const double full = k < 1'000 ? period_s / 2 : between;  // the window is not full at first
        EXPECT_NEAR(encoder.omega(), omega, std::abs(omega) * 2e-9 / std::max(full, period_s / 2));
      }
    }
  }
}

TEST(Encoder, AStoppedShaftsSpeedByPeriodFallsWithTheTimeSinceTheLastEdge) {
  const EncoderParameters p{.lines = 1024, .speed = EncoderSpeed::period, .window_periods = 4};
  Encoder encoder{p};
  const double omega = -20.0;
  std::int64_t k = 0;
  for (; k < 1'000; ++k) encoder.step(omega * double(k) * period_s, k * period_ns);
  const double stop = omega * double(k - 1) * period_s;
  const double stopped_s = double(k - 1) * period_s;
  EXPECT_NEAR(encoder.omega(), omega, 1e-3);
  for (; k < 3'000; ++k) {
    encoder.step(stop, k * period_ns);
    // The last edge came at most one edge's time before the stop.
    const double since = double(k) * period_s - stopped_s;
    if (since > 1e-3) {
      EXPECT_LE(std::abs(encoder.omega()), edge_angle(p) / since * (1 + 1e-6));
    }
    EXPECT_LT(encoder.omega(), 0.0);
  }
}

TEST(Encoder, AShaftThatSwingsOverOneEdgeDoesNotTurn) {
  for (const EncoderSpeed method : {EncoderSpeed::count, EncoderSpeed::period}) {
    const EncoderParameters p{.lines = 100, .speed = method, .window_periods = 10};
    Encoder encoder{p};
    for (int k = 0; k < 1'000; ++k) {
      encoder.step(0.2 * edge_angle(p) * std::sin(0.3 * k), k * period_ns);
      EXPECT_LE(std::abs(encoder.omega()), edge_angle(p) / (10 * period_s) * (1 + 1e-9));
      if (method == EncoderSpeed::period && k > 30) {
        EXPECT_EQ(encoder.omega(), 0.0);
      }
    }
  }
}

TEST(Encoder, FollowsAcrossMissedPeriods) {
  for (const EncoderSpeed method : {EncoderSpeed::count, EncoderSpeed::period}) {
    const EncoderParameters p{.lines = 2500, .speed = method, .window_periods = 8};
    Encoder encoder{p};
    constexpr unsigned seed = 8;
    SCOPED_TRACE(seed);
    std::mt19937 random{seed};
    std::int64_t t_ns = 4'000'000'000'000;
    for (int k = 0; k < 2'000; ++k) {
      t_ns += random() % 10U == 0 ? 13 * period_ns : period_ns;
      encoder.step(80.0 * double(t_ns) * 1e-9, t_ns);
      if (k > 20) {
        EXPECT_NEAR(encoder.omega(), 80.0, method == EncoderSpeed::count ? 3.15 * (1 + 1e-6) : 0.01);
      }
    }
  }
}

TEST(Encoder, AShaftThatHasBeenTurningHasASpeedFromTheFirstSampleOn) {
  for (const EncoderSpeed method : {EncoderSpeed::count, EncoderSpeed::period}) {
    for (const int window : {1, 20, 512}) {
      // At the slowest an edge comes every 2454 periods.
      for (const double omega : {400.0, -80.0, 20.0, 0.025, -0.025, 0.0}) {
        SCOPED_TRACE(testing::Message() << window << " periods at " << omega << " rad/s");
        const EncoderParameters p{.lines = 1024, .speed = method, .window_periods = window};
        const double resolution = edge_angle(p) / (window * period_s);
        const double tolerance = method == EncoderSpeed::count ? resolution : 1e-4 * std::abs(omega);
        Encoder encoder{p};
        encoder.begin(0.3, omega, 7 * period_ns, period_ns);
        for (int k = 0; k < 3'000; ++k) {
          encoder.step(0.3 + omega * k * period_s, (7 + k) * period_ns);
          ASSERT_NEAR(encoder.omega(), omega, tolerance * (1 + 1e-9)) << k;
        }
      }
    }
  }
}

TEST(Encoder, ParametersAreChecked) {
  EXPECT_EQ(EncoderParameters{}.validate(), nullptr);
  EXPECT_TRUE(Encoder{EncoderParameters{}}.is_ideal());
  EXPECT_FALSE(Encoder{EncoderParameters{.lines = 1}}.is_ideal());
  EXPECT_NE((EncoderParameters{.lines = -1}.validate()), nullptr);
  EXPECT_NE((EncoderParameters{.window_periods = 0}.validate()), nullptr);
  EXPECT_NE((EncoderParameters{.window_periods = 513}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
