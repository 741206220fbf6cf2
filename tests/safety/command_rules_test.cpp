#include "sextant/safety/command_rules.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct CommandRules : testing::Test {
  CommandActions evaluate_frame() { return evaluate<frame_rules<>>(facts(), limits); }
  CommandActions evaluate_period() { return evaluate<period_rules<>>(facts(), limits); }
  [[nodiscard]] CommandFacts<> facts() const {
    return {.command = command,
            .age_ns = age_ns,
            .status_age_ns = status_age_ns,
            .is_new = is_new,
            .zero = zero,
            .blocked = blocked};
  }
  [[nodiscard]] static FaultSet only(Fault f) {
    FaultSet set;
    set.set(f);
    return set;
  }

  CommandLimits<> limits{};
  TorqueCommand<> command{.torque = 20, .torque_limit = 100, .enable = true, .e2e = E2eState::valid};
  std::int64_t age_ns{0};
  std::int64_t status_age_ns{0};
  bool is_new{true};
  ZeroRequest zero{ZeroRequest::none};
  std::uint32_t blocked{0};
};

TEST_F(CommandRules, NoneAppliesToAFreshCommandWithinItsLimits) {
  const CommandActions frame = evaluate_frame();
  EXPECT_FALSE(frame.drop || frame.hold || frame.ramp || frame.faults.any());
  const CommandActions period = evaluate_period();
  EXPECT_FALSE(period.drop || period.hold || period.ramp || period.faults.any());
}

TEST_F(CommandRules, AFrameIsDroppedUnlessItsStreamIsValid) {
  for (const E2eState state : {E2eState::no_data, E2eState::init, E2eState::invalid}) {
    command.e2e = state;
    EXPECT_TRUE(evaluate_frame().drop);
  }
}

TEST_F(CommandRules, AgeDropsRampsAndLatchesBeyondItsLimitsOnly) {
  age_ns = limits.timeout_ns;
  EXPECT_FALSE(evaluate_period().ramp);
  age_ns = limits.timeout_ns + 1;
  EXPECT_TRUE(evaluate_period().ramp);
  age_ns = limits.lost_ns;
  EXPECT_FALSE(evaluate_frame().drop);
  EXPECT_FALSE(evaluate_period().faults.any());
  age_ns = limits.lost_ns + 1;
  EXPECT_TRUE(evaluate_frame().drop);
  EXPECT_EQ(evaluate_period().faults, only(Fault::command_lost));
}

TEST_F(CommandRules, ANewEnableBeyondTheTorqueLimitHolds) {
  for (const double torque : {150.1, -150.1, nan}) {
    command.torque = torque;
    is_new = true;
    EXPECT_TRUE(evaluate_frame().hold) << torque;
    is_new = false;
    EXPECT_FALSE(evaluate_frame().hold) << torque;
  }
  command.torque = 150;
  is_new = true;
  EXPECT_FALSE(evaluate_frame().hold);
  for (const double limit : {-1.0, nan}) {
    command.torque_limit = limit;
    EXPECT_TRUE(evaluate_frame().hold) << limit;
  }
  command.enable = false;
  EXPECT_FALSE(evaluate_frame().hold) << "a disable is never blocked";
}

TEST_F(CommandRules, WindingDownRamps) {
  for (const ZeroRequest request : {ZeroRequest::awaits_flux, ZeroRequest::shutdown}) {
    zero = request;
    EXPECT_TRUE(evaluate_period().ramp);
  }
}

// One that is to be told on CAN, in telemetry and in the log.
TEST_F(CommandRules, ARampHasACause) {
  EXPECT_EQ(evaluate_period().cause, DeratingCause::none);
  zero = ZeroRequest::awaits_flux;
  EXPECT_EQ(evaluate_period().cause, DeratingCause::none) << "no torque is taken away";
  zero = ZeroRequest::shutdown;
  EXPECT_EQ(evaluate_period().cause, DeratingCause::shutdown);
  status_age_ns = limits.status_timeout_ns + 1;
  EXPECT_EQ(evaluate_period().cause, DeratingCause::status_timeout);
  age_ns = limits.timeout_ns + 1;
  EXPECT_EQ(evaluate_period().cause, DeratingCause::command_timeout) << "the first that applies";
}

TEST_F(CommandRules, ReceptionLatchesItsFaults) {
  command.e2e = E2eState::invalid;
  EXPECT_EQ(evaluate_period().faults, only(Fault::command_invalid));
  command.e2e = E2eState::valid;
  command.bus_off = true;
  EXPECT_EQ(evaluate_period().faults, only(Fault::bus_off));
  command.bus_off = false;
  blocked = limits.blocked_limit - 1;
  EXPECT_FALSE(evaluate_period().faults.any());
  blocked = limits.blocked_limit;
  EXPECT_EQ(evaluate_period().faults, only(Fault::command_out_of_range));
}

TEST_F(CommandRules, StatusThatIsNotSentRampsAndThenLatches) {
  status_age_ns = limits.status_timeout_ns;
  EXPECT_FALSE(evaluate_period().ramp);
  status_age_ns = limits.status_timeout_ns + 1;
  EXPECT_TRUE(evaluate_period().ramp);
  status_age_ns = limits.status_lost_ns;
  EXPECT_FALSE(evaluate_period().faults.any());
  status_age_ns = limits.status_lost_ns + 1;
  EXPECT_EQ(evaluate_period().faults, only(Fault::transmit_lost));
}

// Facts that are left at their defaults say that nothing has come and nothing is asked.
TEST_F(CommandRules, FactsSayNothingThatIsNotStated) {
  command.torque = 2.0 * limits.torque_limit;
  const CommandFacts<> silent{.command = command};
  EXPECT_FALSE(silent.is_new || silent.disabled || silent.reset || silent.zero != ZeroRequest::none);
  const CommandActions frame = evaluate<frame_rules<>>(silent, limits);
  EXPECT_FALSE(frame.hold) << "a frame out of range counts where it is new";
  EXPECT_FALSE(frame.drop || frame.ramp || frame.faults.any());
  const CommandActions period = evaluate<period_rules<>>(silent, limits);
  EXPECT_FALSE(period.drop || period.hold || period.ramp || period.faults.any());
}

TEST_F(CommandRules, ASecondSenderIsASecondMaster) {
  command.second_sender = true;
  EXPECT_EQ(evaluate_period().faults, only(Fault::second_master));
}

}  // namespace
}  // namespace sextant
