#include "sextant/run/torque_answer.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// What happens in one control period.
struct Period {
  double torque{};   ///< true, constant [N·m]
  double command{};  ///< [N·m]
  DriveState state{DriveState::torque};
  double omega_m{10};        ///< [rad/s]
  double motoring{100};      ///< available [N·m]
  double regenerating{100};  ///< available [N·m]
};

std::optional<MissingTorque> answer(std::int64_t period_ns, std::int64_t end_ns,
                                    const std::function<Period(double)>& at_s) {
  TorqueAnswer answer;
  for (std::int64_t t = -4 * period_ns; t <= end_ns; t += period_ns) {
    const Period p = at_s(double(t) * 1e-9);
    answer.begin_period({.t_ns = t,
                         .omega_m = p.omega_m,
                         .torque_motoring = p.motoring,
                         .torque_regenerating = p.regenerating,
                         .state = p.state},
                        p.command);
    if (t >= 0 && t < end_ns) answer.add_segment(p.torque, p.torque, double(period_ns));
  }
  return answer.missing();
}

TEST(TorqueAnswer, OfADriveThatNeverStartsIsMissingAtEveryPeriod) {
  for (const std::int64_t period_ns : {25'000, 125'000, 250'000, 1'000'000}) {
    const auto missing = answer(period_ns, 500 * ms, [](double) {
      return Period{.torque = 0.25, .command = -400, .state = DriveState::magnetising};
    });
    ASSERT_TRUE(missing) << period_ns;
    EXPECT_NEAR(missing->asked, 400, 1e-9);
    EXPECT_NEAR(missing->made, -0.25, 1e-12) << "against the command";
    EXPECT_EQ(missing->state, DriveState::magnetising);
  }
}

TEST(TorqueAnswer, IsThereOnceTheDriveHasStarted) {
  const auto late = [](double t_s) {
    const bool made = t_s > 0.4;
    return Period{.torque = made ? 58.0 : 0.0,
                  .command = 60,
                  .state = made ? DriveState::torque : DriveState::magnetising};
  };
  EXPECT_FALSE(answer(25'000, 500 * ms, late));
  EXPECT_TRUE(answer(25'000, 300 * ms, late)) << "a run that ends before";
}

TEST(TorqueAnswer, OfADriveInTorqueThatTurnsTheOtherWayOrSwingsIsMissing) {
  const auto constant = [](double torque) {
    return [torque](double) { return Period{.torque = torque, .command = 33.3}; };
  };
  EXPECT_TRUE(answer(50'000, 200 * ms, constant(-28.5)));
  EXPECT_TRUE(answer(50'000, 200 * ms, constant(0)));
  EXPECT_TRUE(answer(50'000, 200 * ms, constant(0.04 * 33.3)));
  EXPECT_FALSE(answer(50'000, 200 * ms, constant(0.06 * 33.3))) << "too little is not none";
  EXPECT_TRUE(answer(50'000, 1000 * ms, [](double t_s) {
    return Period{.torque = 30 * std::sin(2 * std::numbers::pi * 50 * t_s), .command = -20};
  })) << "single-phase running";
}

TEST(TorqueAnswer, FollowsTheSignOfTheCommand) {
  EXPECT_FALSE(answer(50'000, 200 * ms, [](double t_s) {
    const double torque = 20 * std::sin(2 * std::numbers::pi * 10 * t_s);
    return Period{.torque = torque, .command = torque};
  })) << "the mean of both is zero";
}

TEST(TorqueAnswer, NothingIsOwedBeyondTheRangeThatTheDrivePublishes) {
  const auto derated = [](double motoring, double regenerating, double omega_m) {
    return [=](double) {
      return Period{.torque = 0,
                    .command = 60,
                    .state = DriveState::derated,
                    .omega_m = omega_m,
                    .motoring = motoring,
                    .regenerating = regenerating};
    };
  };
  EXPECT_FALSE(answer(50'000, 200 * ms, derated(0, 80, 50)));
  EXPECT_TRUE(answer(50'000, 200 * ms, derated(0, 80, -50))) << "it may brake";
  EXPECT_FALSE(answer(50'000, 200 * ms, derated(80, 0, -50)));
}

TEST(TorqueAnswer, LittleThatIsAskedOrBrieflyIsNotJudged) {
  const auto small = [](double) { return Period{.torque = -1, .command = 4.9}; };
  EXPECT_FALSE(answer(50'000, 200 * ms, small)) << "less than the errors of a drive of 100 N·m";
  const auto brief = [](double t_s) { return Period{.command = t_s >= 0.181 ? 60.0 : 0.0}; };
  EXPECT_FALSE(answer(50'000, 200 * ms, brief));
  const auto longer = [](double t_s) { return Period{.command = t_s >= 0.179 ? 60.0 : 0.0}; };
  EXPECT_TRUE(answer(50'000, 200 * ms, longer));
  EXPECT_FALSE(answer(50'000, 200 * ms, [](double) { return Period{.torque = 5}; })) << "nothing was asked";
}

}  // namespace
}  // namespace sextant
