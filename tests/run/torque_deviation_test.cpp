#include "sextant/run/torque_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/run/metrics.hpp"
#include "sextant/run/sliding_maximum.hpp"
#include "sextant/run/sliding_mean.hpp"

namespace sextant {
namespace {

constexpr std::int64_t period_ns = 25'000;
constexpr std::int64_t ms = 1'000'000;
constexpr double tolerance = 2;  // [N·m]

/// What happens in one control period.
struct Period {
  double torque{};   ///< true, constant [N·m]
  double command{};  ///< [N·m]
  Telemetry<double> telemetry{
      .omega_m = 10, .torque_motoring = 150, .torque_regenerating = 150, .state = DriveState::torque};
};

TorqueDeviation run(std::int64_t from_ns, std::int64_t to_ns, std::int64_t end_ns,
                    const std::function<Period(std::int64_t)>& at) {
  TorqueDeviation deviation{period_ns, from_ns, to_ns, tolerance};
  for (std::int64_t t = 0; t <= end_ns; t += period_ns) {
    Period p = at(t);
    p.telemetry.t_ns = t;
    deviation.begin_period(p.telemetry, p.command);
    deviation.add_segment(p.torque, p.torque, period_ns);
  }
  return deviation;
}

TorqueDeviation run(std::int64_t end_ns, const std::function<Period(std::int64_t)>& at) {
  return run(0, end_ns, end_ns, at);
}

TEST(SlidingMaximum, IsThatOfTheLastValuesInAnyOrder) {
  std::uniform_int_distribution<int> value{-9, 9};
  for (const unsigned seed : {1U, 2U, 7U}) {
    std::mt19937 random{seed};
    const std::size_t n = seed;
    SlidingMaximum maximum{n};
    std::vector<double> all;
    for (int k = 0; k < 500; ++k) {
      all.push_back(value(random));
      maximum.push(all.back());
      const auto begin = all.end() - std::ptrdiff_t(std::min(n, all.size()));
      ASSERT_EQ(maximum.value(), *std::max_element(begin, all.end())) << "seed and length " << n << ", " << k;
    }
    maximum.clear();
    maximum.push(-100);
    EXPECT_EQ(maximum.value(), -100) << "the values before are gone";
  }
}

TEST(SlidingMean, IsThatOfTheLastValuesAndKeepsNoRoundingErrorOfThoseBefore) {
  SlidingMean mean{3};
  for (const double value : {1.0, 2.0}) mean.push(value);
  EXPECT_FALSE(mean.full());
  mean.push(6);
  EXPECT_TRUE(mean.full());
  EXPECT_DOUBLE_EQ(mean.value(), 3);
  mean.push(10);
  EXPECT_DOUBLE_EQ(mean.value(), 6);
  mean.push(1e17);  // its difference to small values is not exact
  for (int k = 0; k < 6; ++k) mean.push(0.1);
  EXPECT_DOUBLE_EQ(mean.value(), 0.1);
  mean.clear();
  EXPECT_FALSE(mean.full());
}

TEST(TorqueDeviation, IsThatOfTheMeanAndNotOfTheRipple) {
  const TorqueDeviation d = run(200 * ms, [](std::int64_t t) {
    const double ripple = t / period_ns % 2 == 0 ? 40 : -40;
    return Period{.torque = 15 + 1.5 + ripple, .command = 15};
  });
  EXPECT_NEAR(d.largest(), 1.5, 1e-9);
  EXPECT_EQ(d.longest_ms(), 0.0);
}

TEST(TorqueDeviation, ATorqueThatLeavesTheCommandIsSilentFromWhereTheMeanLeavesItsTolerance) {
  // 100 ms after the drive has been commanded the torque falls by 30 N·m: the mean by 30 N·m · t/20 ms, by
  // the tolerance of 5 N·m after 10/3 ms.
  const TorqueDeviation d = run(
      200 * ms, [](std::int64_t t) { return Period{.torque = t < 100 * ms ? 100.0 : 70.0, .command = 100}; });
  EXPECT_NEAR(d.largest(), 30, 1e-9);
  EXPECT_NEAR(d.longest_ms(), 100 - 10.0 / 3, 0.026);
}

TEST(TorqueDeviation, ToleratesTwoNewtonMetresAndFivePercent) {
  struct Case {
    double command, error;
    bool silent;
  };
  for (const Case c : {Case{0, 1.99, false}, Case{0, -1.99, false}, Case{0, 2.01, true}, Case{0, -2.01, true},
                       Case{-130, 6.49, false}, Case{-130, 6.51, true}, Case{-130, -6.51, true}}) {
    SCOPED_TRACE(testing::Message() << c.command << " N·m, error " << c.error);
    const TorqueDeviation d = run(
        100 * ms, [c](std::int64_t) { return Period{.torque = c.command + c.error, .command = c.command}; });
    EXPECT_NEAR(d.largest(), std::abs(c.error), 1e-9);
    EXPECT_EQ(d.longest_ms() > 0, c.silent);
  }
}

// On a machine of 7.5 N·m two newton metres would be a quarter of its torque.
TEST(TorqueDeviation, TheLeastToleranceIsThatOfTheDrive) {
  for (const double least : {0.1, 2.0, 27.0}) {
    for (const double share : {0.99, 1.01}) {
      TorqueDeviation d{period_ns, 0, 100 * ms, least};
      for (std::int64_t t = 0; t <= 100 * ms; t += period_ns) {
        Period p{.command = least};
        p.telemetry.t_ns = t;
        d.begin_period(p.telemetry, p.command);
        d.add_segment((1 + share) * least, (1 + share) * least, period_ns);
      }
      EXPECT_EQ(d.longest_ms() > 0, share > 1) << least;
    }
  }
}

TEST(TorqueDeviation, ATripEndsIt) {
  for (const std::int64_t reaction : {8 * ms, 12 * ms}) {
    const TorqueDeviation d = run(200 * ms, [reaction](std::int64_t t) {
      Period p{.torque = t < 100 * ms ? 15.0 : -300.0, .command = 15};
      if (t >= 100 * ms + reaction) {
        p.telemetry.state = DriveState::fault;
        p.telemetry.latched.set(Fault::over_current);
        p.torque = 0;
      }
      return p;
    });
    // 315 N·m move the mean out of its tolerance within 0.13 ms.
    EXPECT_NEAR(d.longest_ms(), double(reaction) * 1e-6 - 2.0 / 315 * 20, 0.026);
    EXPECT_NEAR(d.largest(), 315 * double(reaction) / (20.0 * ms), 1e-6);
  }
}

TEST(TorqueDeviation, AfterGatesOffTheMeanBeginsAnew) {
  const TorqueDeviation d = run(100 * ms, 200 * ms, 200 * ms, [](std::int64_t t) {
    Period p{.torque = t < 90 * ms ? 35.0 : 15.0, .command = 15};
    if (t >= 90 * ms && t < 105 * ms) {
      p.telemetry.state = DriveState::ready;
      p.torque = -200;
    }
    return p;
  });
  EXPECT_NEAR(d.largest(), 0, 1e-9);
}

TEST(TorqueDeviation, ADeratedDriveDeliversWhatItPublishes) {
  // 60 N·m commanded, −50 delivered, until the drive publishes that it has nothing and delivers nothing.
  const auto derating = [](std::int64_t reaction) {
    return run(200 * ms, [reaction](std::int64_t t) {
      Period p{.torque = t < 100 * ms ? 60.0 : -50.0, .command = 60};
      if (t >= 100 * ms + reaction) {
        p.telemetry.state = DriveState::derated;
        p.telemetry.torque_motoring = 0;
        p.torque = 0;
      }
      return p;
    });
  };
  EXPECT_LE(derating(8 * ms).longest_ms(), 8);
  EXPECT_GT(derating(12 * ms).longest_ms(), 11);

  const TorqueDeviation in_and_out = run(300 * ms, [](std::int64_t t) {
    Period p{.torque = t < 100 * ms ? 60.0 : -50.0, .command = 60};
    p.telemetry.torque_motoring = 50;
    if (t / (5 * ms) % 2 == 0) p.telemetry.state = DriveState::derated;
    return p;
  });
  EXPECT_GT(in_and_out.longest_ms(), 190) << "a state that comes and goes announces nothing";

  const TorqueDeviation beyond = run(100 * ms, [](std::int64_t) {
    Period p{.torque = 60, .command = 60};
    p.telemetry.torque_motoring = 20;
    return p;
  });
  EXPECT_NEAR(beyond.largest(), 40, 1e-9) << "more than published";
}

// Regenerated torque overshoots for 15 ms after a sag of the link, and the drive says how far. The mean of 20
// ms leaves the command for longer.
TEST(TorqueDeviation, ATorqueThatTheDriveSaysTheVoltageHoldsOffItsReferenceIsNone) {
  const auto sag = [](double torque, DriveState state, DeratingCause cause, double reached) {
    return run(400 * ms, [=](std::int64_t t) {
      Period p{.torque = -100, .command = -100};
      p.telemetry.torque_reference = p.telemetry.torque_reached = -100;
      if (t >= 200 * ms && t < 215 * ms) {
        p.torque = torque;
        p.telemetry.state = state;
        p.telemetry.derating_cause = cause;
        p.telemetry.torque_reached = reached;
      }
      return p;
    });
  };
  constexpr auto derated = DriveState::derated;
  constexpr auto voltage = DeratingCause::voltage_limit;
  for (const double torque : {-101.0, -140.0, -160.0}) {
    EXPECT_NEAR(sag(torque, derated, voltage, -160).largest(), 0, 1e-9) << torque;
    EXPECT_EQ(sag(torque, derated, voltage, -160).longest_ms(), 0) << torque;
  }
  const double beyond = 20;
  const double span = 15.0 / 20;  // of the mean
  EXPECT_NEAR(sag(-160 - beyond, derated, voltage, -160).largest(), span * beyond, 1e-9);
  EXPECT_GT(sag(-160 - beyond, derated, voltage, -160).longest_ms(), 10) << "excuses no other torque";
  EXPECT_GT(sag(-100 + beyond, derated, voltage, -160).longest_ms(), 10);
  EXPECT_NEAR(sag(-100 + beyond, derated, voltage, -160).largest(), span * beyond, 1e-9) << "the other way";
  for (const double reached : {-100.0, 0.0, -60.0}) {
    EXPECT_NEAR(sag(-160, derated, voltage, reached).largest(), span * 60, 1e-9) << reached;
  }
  EXPECT_NEAR(sag(-160, DriveState::torque, voltage, -160).largest(), span * 60, 1e-9) << "says nothing";
  EXPECT_NEAR(sag(-160, derated, DeratingCause::current_limit, -160).largest(), span * 60, 1e-9);
  EXPECT_NEAR(sag(-160, derated, DeratingCause::none, -160).largest(), span * 60, 1e-9);
}

TEST(TorqueDeviation, TheDirectionOfTheSpeedDecidesWhichLimitHolds) {
  for (const double omega_m : {10.0, -10.0}) {
    for (const double command : {100.0, -100.0}) {
      const double available = command * omega_m > 0 ? 30 : 70;
      const TorqueDeviation d = run(100 * ms, [=](std::int64_t) {
        Period p{.torque = std::copysign(available, command), .command = command};
        p.telemetry.omega_m = omega_m;
        p.telemetry.torque_motoring = 30;
        p.telemetry.torque_regenerating = 70;
        return p;
      });
      EXPECT_NEAR(d.largest(), 0, 1e-9) << omega_m << " rad/s, " << command << " N·m";
    }
  }
}

TEST(TorqueDeviation, ACommandThatMovesIsNone) {
  const TorqueDeviation step = run(300 * ms, [](std::int64_t t) {
    const double torque = t < 100 * ms ? -100 : 100;
    return Period{.torque = torque, .command = torque};
  });
  EXPECT_NEAR(step.largest(), 0, 1e-9);
  const TorqueDeviation stays = run(300 * ms, [](std::int64_t t) {
    return Period{.torque = -100, .command = t < 100 * ms ? -100.0 : 100.0};
  });
  EXPECT_NEAR(stays.largest(), 200, 1e-9);
  EXPECT_NEAR(stays.longest_ms(), 180, 0.026) << "20 ms after the step";
}

TEST(TorqueDeviation, MagnetisingDeliversNoTorque) {
  for (const double torque : {0.0, 60.0}) {
    const TorqueDeviation d = run(100 * ms, [torque](std::int64_t) {
      Period p{.torque = torque, .command = 60};
      p.telemetry.state = DriveState::magnetising;
      return p;
    });
    EXPECT_NEAR(d.largest(), torque, 1e-9);
  }
}

TEST(TorqueDeviation, CountsInItsWindowAndNeedsTwentyMilliseconds) {
  const auto at = [](std::int64_t t) {
    return Period{.torque = t > 100 * ms && t < 150 * ms ? 10.0 : 0.0, .command = 0};
  };
  EXPECT_NEAR(run(0, 100 * ms, 200 * ms, at).largest(), 0, 1e-9);
  EXPECT_NEAR(run(175 * ms, 200 * ms, 200 * ms, at).largest(), 0, 1e-9);
  EXPECT_NEAR(run(120 * ms, 130 * ms, 200 * ms, at).longest_ms(), 10, 0.026);
  EXPECT_TRUE(std::isnan(run(0, 19 * ms, 200 * ms, at).largest()));
  EXPECT_TRUE(std::isnan(run(0, 19 * ms, 200 * ms, at).longest_ms()));
}

TEST(TorqueDeviation, TheAvailableTorqueIsItsMeanUpToAFault) {
  const auto at = [](std::int64_t t) {
    Period p;
    p.telemetry.torque_motoring = t < 150 * ms ? 100 : 50;
    p.telemetry.torque_regenerating = 120;
    if (t > 200 * ms) {
      p.telemetry.latched.set(Fault::over_current);
      p.telemetry.torque_motoring = 0;
    }
    return p;
  };
  const TorqueDeviation d = run(100 * ms, 300 * ms, 300 * ms, at);
  EXPECT_NEAR(d.motoring(), 75, 0.02);
  EXPECT_NEAR(d.regenerating(), 120, 1e-9);
  EXPECT_TRUE(std::isnan(run(250 * ms, 300 * ms, 300 * ms, at).motoring()));
}

TEST(TorqueDeviation, OfARunWithoutControlPeriodsThereIsNone) {
  for (const bool has_period : {false, true}) {
    MetricsAccumulator metrics{{}};
    if (has_period) metrics.has_control_period(period_ns);
    for (std::int64_t t = 0; t < 50 * ms; t += period_ns) {
      Telemetry<double> telemetry = Period{}.telemetry;
      telemetry.t_ns = t;
      metrics.begin_period(telemetry, 15);
      metrics.add_segment({.t_ns = t, .torque = 10}, {.t_ns = t + period_ns, .torque = 12});
    }
    const MetricList m = metrics.metrics();
    if (has_period) {
      EXPECT_NEAR(m[Metric::torque_deviation], 4, 1e-9);
      EXPECT_NEAR(m[Metric::torque_silent], 30, 0.051);
      EXPECT_EQ(m[Metric::torque_motoring], 150);
      EXPECT_EQ(m[Metric::torque_regenerating], 150);
    } else {
      EXPECT_TRUE(std::isnan(m[Metric::torque_deviation]));
      EXPECT_TRUE(std::isnan(m[Metric::torque_silent]));
      EXPECT_TRUE(std::isnan(m[Metric::torque_motoring]));
    }
  }
}

}  // namespace
}  // namespace sextant
