#include "sextant/safety/command_supervision.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t period_ns = 25'000;

template <class T>
class CommandSupervisionOf : public testing::Test {
 protected:
  using Limits = typename CommandSupervision<T>::Parameters;
  static constexpr T nan = std::numeric_limits<T>::quiet_NaN();

  /// A frame arrives now.
  void receive(T torque, bool enable, bool fault_reset = false) {
    command.torque = torque;
    command.torque_limit = T(150);
    command.enable = enable;
    command.fault_reset = fault_reset;
    command.received_ns = t_ns;
    command.e2e = E2eState::valid;
    ++command.sequence;
  }

  SupervisedCommand<T> step() {
    const auto out = supervision.step(command, t_ns, T(period_ns) * T(1e-9), {-available, available}, zero);
    t_ns += period_ns;
    return out;
  }

  /// Steps until t_ns has advanced by `duration`; the last answer.
  SupervisedCommand<T> run(std::int64_t duration) {
    SupervisedCommand<T> out;
    for (const std::int64_t end = t_ns + duration; t_ns < end;) out = step();
    return out;
  }

  /// Past the lockout, with `torque` commanded and reached.
  void start(T torque) {
    receive(T(0), false);
    step();
    receive(torque, true);
    const auto out = run(ms);
    ASSERT_TRUE(out.enable);
    ASSERT_EQ(out.torque, torque);
  }

  Limits limits{};
  CommandSupervision<T> supervision{limits};
  TorqueCommand<T> command{};
  std::int64_t t_ns{5 * ms};
  T available{T(150)};
  ZeroRequest zero{ZeroRequest::none};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CommandSupervisionOf, Scalars);

TYPED_TEST(CommandSupervisionOf, WithoutAnyCommandItStaysLocked) {
  const auto out = this->run(300 * ms);
  EXPECT_TRUE(out.lockout);
  EXPECT_FALSE(out.enable);
  EXPECT_EQ(out.torque, TypeParam(0));
}

TYPED_TEST(CommandSupervisionOf, EnableAtPowerUpDoesNothingUntilADisableWasSeen) {
  using T = TypeParam;
  for (int i = 0; i < 20; ++i) {
    this->receive(T(15), true);
    const auto out = this->run(10 * ms);
    EXPECT_TRUE(out.lockout);
    EXPECT_FALSE(out.enable);
    EXPECT_EQ(out.torque, T(0));
  }
  this->receive(T(15), false);
  EXPECT_FALSE(this->step().lockout);
  this->receive(T(15), true);
  const auto out = this->run(10 * ms);
  EXPECT_TRUE(out.enable);
  EXPECT_EQ(out.torque, T(15));
}

TYPED_TEST(CommandSupervisionOf, SilenceBringsZeroTorqueWithinSixtyMillisecondsFromAnyTorque) {
  using T = TypeParam;
  for (const T torque : {T(150), T(-150), T(15), T(0.01), T(-0.001)}) {
    this->supervision = CommandSupervision<T>{typename TestFixture::Limits{}};
    this->start(torque);
    const std::int64_t received = this->command.received_ns;
    while (this->t_ns - received <= 40 * ms) ASSERT_EQ(this->step().torque, torque);
    T last = torque;
    while (this->t_ns - received < 60 * ms) {
      const auto out = this->step();
      ASSERT_LE(std::abs(out.torque), std::abs(last));
      ASSERT_FALSE(out.faults.any());
      ASSERT_TRUE(out.enable);
      last = out.torque;
    }
    EXPECT_EQ(last, T(0));
    EXPECT_EQ(this->run(100 * ms).torque, T(0));
  }
}

TYPED_TEST(CommandSupervisionOf, TheRampToZeroIsStraightAndTakesItsTime) {
  using T = TypeParam;
  this->start(T(100));
  const std::int64_t received = this->command.received_ns;
  while (this->t_ns - received <= 45 * ms) this->step();
  EXPECT_NEAR(this->step().torque, T(50), T(0.6));
}

TYPED_TEST(CommandSupervisionOf, ATimeoutHealsByItself) {
  using T = TypeParam;
  this->start(T(15));
  EXPECT_EQ(this->run(100 * ms).torque, T(0));
  this->receive(T(12), true);
  const auto out = this->run(ms);
  EXPECT_EQ(out.torque, T(12));
  EXPECT_FALSE(out.faults.any());
}

TYPED_TEST(CommandSupervisionOf, ALostCommandIsAFaultAndLocks) {
  using T = TypeParam;
  this->start(T(15));
  const std::int64_t received = this->command.received_ns;
  while (this->t_ns - received <= 200 * ms) ASSERT_FALSE(this->step().faults.any());
  const auto out = this->step();
  EXPECT_TRUE(out.faults.test(Fault::command_lost));
  EXPECT_TRUE(out.lockout);
  EXPECT_FALSE(out.enable);
  this->receive(T(15), true);
  EXPECT_TRUE(this->run(ms).lockout);
  this->receive(T(0), false);
  EXPECT_FALSE(this->step().lockout);
}

TYPED_TEST(CommandSupervisionOf, AStampFromTheFutureDoesNotStopACommandsAge) {
  using T = TypeParam;
  this->start(T(15));
  this->receive(T(15), true);
  this->command.received_ns += 3'600'000 * ms;
  EXPECT_EQ(this->run(39 * ms).torque, T(15));
  EXPECT_EQ(this->run(20 * ms).torque, T(0));
  EXPECT_TRUE(this->run(150 * ms).faults.test(Fault::command_lost));
}

TYPED_TEST(CommandSupervisionOf, AFrameThatIsLostBeforeItIsReadCountsForNothing) {
  using T = TypeParam;
  this->receive(T(15), false, true);
  this->command.received_ns -= 201 * ms;
  const auto out = this->step();
  EXPECT_TRUE(out.lockout);
  EXPECT_FALSE(out.fault_reset);
}

TYPED_TEST(CommandSupervisionOf, AResetIsSeenForOnePeriodAndDoesNotUnlock) {
  using T = TypeParam;
  this->receive(T(0), false, true);
  auto out = this->step();
  EXPECT_TRUE(out.fault_reset);
  EXPECT_TRUE(out.lockout);
  out = this->step();
  EXPECT_FALSE(out.fault_reset);
  EXPECT_TRUE(out.lockout);
  this->receive(T(0), false);
  EXPECT_FALSE(this->step().lockout);
}

TYPED_TEST(CommandSupervisionOf, LockDemandsANewDisableAndForgetsTheSetpoint) {
  using T = TypeParam;
  this->start(T(15));
  this->supervision.lock();
  const auto out = this->step();
  EXPECT_TRUE(out.lockout);
  EXPECT_FALSE(out.enable);
  EXPECT_EQ(out.torque, T(0));
}

TYPED_TEST(CommandSupervisionOf, TorqueBeyondTheLimitIsBlockedAndTheLastSetpointHolds) {
  using T = TypeParam;
  const T infinity = std::numeric_limits<T>::infinity();
  for (const T bad : {T(150.1), T(-150.1), this->nan, infinity, -infinity}) {
    this->supervision = CommandSupervision<T>{typename TestFixture::Limits{}};
    this->start(T(15));
    for (int frame = 1; frame <= 3; ++frame) {
      this->receive(bad, true);
      const auto out = this->run(10 * ms);
      EXPECT_EQ(out.faults.test(Fault::command_out_of_range), frame == 3) << bad;
      if (frame < 3) {
        EXPECT_EQ(out.torque, T(15));
      } else {
        EXPECT_FALSE(out.enable);
      }
    }
  }
}

TYPED_TEST(CommandSupervisionOf, BlockedFramesMustComeInARowToBeAFault) {
  using T = TypeParam;
  this->start(T(15));
  for (int i = 0; i < 10; ++i) {
    for (const T torque : {T(400), T(400), T(10)}) {
      this->receive(torque, true);
      EXPECT_FALSE(this->run(10 * ms).faults.any());
    }
  }
}

TYPED_TEST(CommandSupervisionOf, FramesOutsideTheContractCountTheSame) {
  this->start(TypeParam(15));
  this->command.out_of_range = 2;
  EXPECT_FALSE(this->step().faults.any());
  this->command.out_of_range = 3;
  EXPECT_TRUE(this->step().faults.test(Fault::command_out_of_range));
}

// Beyond the contract's range (dropped by the receiver) and beyond the configured limit (dropped here),
// mixed.
TYPED_TEST(CommandSupervisionOf, ThreeBadFramesInARowAreAFaultWhateverIsWrongWithEach) {
  using T = TypeParam;
  for (const unsigned kinds : {0b000U, 0b001U, 0b010U, 0b011U, 0b100U, 0b101U, 0b110U, 0b111U}) {
    SCOPED_TRACE(kinds);
    this->supervision = CommandSupervision<T>{{}};
    this->command = {};
    this->start(T(15));
    for (unsigned frame = 0; frame < 3; ++frame) {
      if ((kinds >> frame & 1U) != 0) {
        ++this->command.out_of_range;
      } else {
        this->command.out_of_range = 0;  // as the receiver does when it accepts a frame
        this->receive(T(400), true);
      }
      EXPECT_EQ(this->run(10 * ms).faults.test(Fault::command_out_of_range), frame == 2);
    }
    this->command.out_of_range = 0;
    this->receive(T(10), true);
    EXPECT_FALSE(this->run(ms).faults.any()) << "a good frame ends it";
  }
}

TYPED_TEST(CommandSupervisionOf, AGoodFrameBetweenFramesOutsideTheContractStartsTheCountAgain) {
  using T = TypeParam;
  this->start(T(15));
  for (int i = 0; i < 10; ++i) {
    this->command.out_of_range = 2;
    EXPECT_FALSE(this->run(10 * ms).faults.any());
    this->command.out_of_range = i % 2 == 0 ? 0 : 2;  // 2: two more came in the same look
    this->receive(T(10), true);
    EXPECT_FALSE(this->run(10 * ms).faults.any());
  }
}

TYPED_TEST(CommandSupervisionOf, ANewFrameIsEvaluatedAlsoWhileAllIsWell) {
  using T = TypeParam;
  this->start(T(15));
  this->receive(T(20), true);
  EXPECT_EQ(this->run(ms).torque, T(20));
  this->receive(T(20), false);
  const auto out = this->step();
  EXPECT_FALSE(out.enable);
  EXPECT_LT(out.torque, T(20));
}

TYPED_TEST(CommandSupervisionOf, AFrameThatIsOldWhenItIsReadRampsToZero) {
  using T = TypeParam;
  this->start(T(15));
  this->receive(T(20), true);
  this->command.received_ns = this->t_ns - this->limits.timeout_ns - 1;
  const auto out = this->step();
  EXPECT_TRUE(out.enable);
  EXPECT_LT(out.torque, T(15));
}

TYPED_TEST(CommandSupervisionOf, AGoodFrameForgetsWhatWasOutsideTheContractBefore) {
  using T = TypeParam;
  this->start(T(15));
  this->command.out_of_range = 2;
  this->step();
  this->receive(T(15), true);
  this->command.out_of_range = 0;
  this->step();
  this->command.out_of_range = 2;
  EXPECT_FALSE(this->step().faults.any());
  this->command.out_of_range = 3;
  EXPECT_TRUE(this->step().faults.test(Fault::command_out_of_range));
}

TYPED_TEST(CommandSupervisionOf, ALimitThatIsNoneBlocksTheFrame) {
  using T = TypeParam;
  for (const T bad : {this->nan, T(-1)}) {
    this->start(T(15));
    this->receive(T(100), true);
    this->command.torque_limit = bad;
    EXPECT_EQ(this->run(ms).torque, T(15));
  }
}

TYPED_TEST(CommandSupervisionOf, ABlockedFrameNeitherEnablesNorResets) {
  using T = TypeParam;
  this->receive(T(0), false);
  this->step();
  this->receive(this->nan, true, true);
  const auto out = this->step();
  EXPECT_FALSE(out.enable);
  EXPECT_FALSE(out.fault_reset);
  this->receive(T(15), true);
  EXPECT_TRUE(this->step().enable);
}

// A vehicle that asks for no torque may well say that it has none to ask for.
TYPED_TEST(CommandSupervisionOf, ADisableIsADisableWhateverItsTorque) {
  using T = TypeParam;
  const T infinity = std::numeric_limits<T>::infinity();
  for (const T torque : {T(150.1), T(-400), this->nan, infinity, -infinity}) {
    SCOPED_TRACE(torque);
    this->supervision = CommandSupervision<T>{{}};
    this->start(T(15));
    for (int frame = 0; frame < 10; ++frame) {
      this->receive(torque, false);
      const auto out = this->run(10 * ms);
      EXPECT_FALSE(out.enable);
      EXPECT_FALSE(out.faults.any()) << "frame " << frame;
      EXPECT_EQ(out.torque, T(0));
    }
    this->receive(T(15), true);
    EXPECT_EQ(this->run(ms).torque, T(15));
  }
}

TYPED_TEST(CommandSupervisionOf, ADisableEndsTheLockoutAndAResetResetsWhateverTheirTorque) {
  this->receive(this->nan, false, true);
  this->command.torque_limit = this->nan;
  auto out = this->step();
  EXPECT_TRUE(out.fault_reset);
  EXPECT_TRUE(out.lockout) << "a frame that resets is spent on the reset";
  this->receive(this->nan, false);
  this->command.torque_limit = this->nan;
  EXPECT_FALSE(this->step().lockout);
}

TYPED_TEST(CommandSupervisionOf, ADisableBetweenBlockedFramesBreaksTheirRow) {
  using T = TypeParam;
  this->start(T(15));
  for (int frame = 0; frame < 6; ++frame) {
    this->receive(T(400), frame % 3 != 2);
    EXPECT_FALSE(this->run(10 * ms).faults.any());
  }
}

// The control thread sees the newest command only: what came between is known by its count.
TYPED_TEST(CommandSupervisionOf, ADisableThatWasOverwrittenDisablesForAPeriodAndTorqueStartsFromZero) {
  using T = TypeParam;
  this->supervision = CommandSupervision<T>{{.torque_rate = T(1000)}};
  this->receive(T(0), false);
  this->step();
  this->receive(T(15), true);
  ASSERT_EQ(this->run(20 * ms).torque, T(15));
  ++this->command.disables;
  this->receive(T(15), true);
  auto out = this->step();
  EXPECT_FALSE(out.enable);
  EXPECT_FALSE(out.lockout);
  EXPECT_EQ(out.torque, T(0));
  out = this->step();
  EXPECT_TRUE(out.enable);
  EXPECT_NEAR(out.torque, T(0.025), T(1e-6));
}

TYPED_TEST(CommandSupervisionOf, ADisableThatWasOverwrittenByABlockedFrameHolds) {
  using T = TypeParam;
  this->start(T(15));
  ++this->command.disables;
  this->receive(T(400), true);
  EXPECT_FALSE(this->run(10 * ms).enable);
  this->receive(T(15), true);
  EXPECT_TRUE(this->step().enable);
}

TYPED_TEST(CommandSupervisionOf, ADisableThatWasOverwrittenEndsTheLockout) {
  using T = TypeParam;
  ++this->command.disables;
  this->receive(T(15), true);
  auto out = this->step();
  EXPECT_FALSE(out.lockout);
  EXPECT_FALSE(out.enable);
  out = this->step();
  EXPECT_TRUE(out.enable);
}

TYPED_TEST(CommandSupervisionOf,
           ADisableThatWasOverwrittenEndsNoLockoutWhileTheCheckIsNotValidOrTheCommandLost) {
  using T = TypeParam;
  ++this->command.disables;
  this->receive(T(15), true);
  this->command.e2e = E2eState::init;
  EXPECT_TRUE(this->step().lockout);
  this->command.e2e = E2eState::valid;
  EXPECT_TRUE(this->step().lockout) << "that disable has been judged";

  ++this->command.disables;
  this->receive(T(15), true);
  this->command.received_ns -= 201 * ms;
  EXPECT_TRUE(this->step().lockout);
  this->receive(T(15), true);
  EXPECT_TRUE(this->step().lockout);
}

TYPED_TEST(CommandSupervisionOf, AResetThatWasOverwrittenResetsAndItsDisableEndsNoLockout) {
  using T = TypeParam;
  ++this->command.disables;
  ++this->command.resets;
  this->receive(T(15), true);
  auto out = this->step();
  EXPECT_TRUE(out.fault_reset);
  EXPECT_TRUE(out.lockout);
  out = this->step();
  EXPECT_FALSE(out.fault_reset);
  EXPECT_TRUE(out.lockout);
}

// A disable that is the newest command came after every reset; of one that was overwritten that is not known.
TYPED_TEST(CommandSupervisionOf, WhereResetAndDisableCameAtOnceTheOrderDecidesAboutTheLockout) {
  using T = TypeParam;
  this->command.disables += 2;
  ++this->command.resets;
  this->receive(T(0), false);
  auto out = this->step();
  EXPECT_TRUE(out.fault_reset);
  EXPECT_FALSE(out.lockout);

  this->supervision.lock();
  this->command.disables += 2;
  ++this->command.resets;
  this->receive(T(15), true);
  out = this->step();
  EXPECT_TRUE(out.fault_reset);
  EXPECT_TRUE(out.lockout);
}

TYPED_TEST(CommandSupervisionOf, AFrameThatEnablesIsNeverAReset) {
  using T = TypeParam;
  for (const T torque : {T(0), T(20), T(400)}) {
    this->receive(torque, true, true);
    EXPECT_FALSE(this->step().fault_reset) << "locked out, torque " << torque;
  }
  this->supervision = CommandSupervision<T>{{}};
  this->start(T(15));
  this->receive(T(20), true, true);
  auto out = this->step();
  EXPECT_FALSE(out.fault_reset);
  EXPECT_EQ(out.torque, T(20)) << "the rest of the frame counts";

  this->supervision.lock();
  ++this->command.disables;
  this->receive(T(20), true, true);
  out = this->step();
  EXPECT_FALSE(out.fault_reset);
  EXPECT_FALSE(out.lockout) << "the disable before it is one without a reset";
  EXPECT_FALSE(out.enable);
}

TYPED_TEST(CommandSupervisionOf, TheReferenceStaysWithinWhatIsAvailableHoweverSlowTheTorqueFalls) {
  using T = TypeParam;
  this->start(T(100));
  this->run(ms);
  this->available = T(30);
  EXPECT_LE(this->step().torque, T(30));
  this->zero = ZeroRequest::shutdown;
  this->available = T(10);
  EXPECT_LE(this->step().torque, T(10));
}

TYPED_TEST(CommandSupervisionOf, CountsMayWrap) {
  using T = TypeParam;
  this->command.sequence = std::numeric_limits<decltype(this->command.sequence)>::max() - 2;
  this->command.disables = std::numeric_limits<decltype(this->command.disables)>::max();
  this->start(T(15));
  for (int frame = 0; frame < 5; ++frame) {
    this->receive(T(15), true);
    const auto out = this->run(10 * ms);
    EXPECT_TRUE(out.enable) << "sequence " << this->command.sequence;
    EXPECT_FALSE(out.lockout);
    EXPECT_EQ(out.torque, T(15));
  }
  ++this->command.disables;
  EXPECT_FALSE(this->step().enable);
}

TYPED_TEST(CommandSupervisionOf, TheRequestersLimitCutsTheTorque) {
  using T = TypeParam;
  this->start(T(15));
  for (const T torque : {T(50), T(-50)}) {
    this->receive(torque, true);
    this->command.torque_limit = T(20);
    const auto out = this->run(ms);
    EXPECT_EQ(out.torque, std::copysign(T(20), torque));
    EXPECT_FALSE(out.derated);
  }
}

TYPED_TEST(CommandSupervisionOf, TorqueFollowsAtTheConfiguredRate) {
  using T = TypeParam;
  this->supervision = CommandSupervision<T>{{.torque_rate = T(1000)}};
  this->receive(T(0), false);
  this->step();
  this->receive(T(100), true);
  T last{};
  for (int i = 1; i <= 400; ++i) {
    const T torque = this->step().torque;
    EXPECT_NEAR(torque - last, T(0.025), T(1e-4));
    last = torque;
  }
  EXPECT_NEAR(last, T(10), T(1e-2));
}

TYPED_TEST(CommandSupervisionOf, MoreThanIsAvailableIsSaturatedAndSaidSo) {
  using T = TypeParam;
  this->start(T(-100));
  this->available = T(40);
  auto out = this->run(ms);
  EXPECT_EQ(out.torque, T(-40));
  EXPECT_TRUE(out.derated);
  EXPECT_FALSE(out.faults.any());
  this->available = T(150);
  out = this->run(ms);
  EXPECT_EQ(out.torque, T(-100));
  EXPECT_FALSE(out.derated);
}

TYPED_TEST(CommandSupervisionOf, EachDirectionHasItsOwnAvailability) {
  using T = TypeParam;
  this->start(T(100));
  const auto step = [this] {
    this->t_ns += period_ns;
    return this->supervision.step(this->command, this->t_ns, T(1), {T(-60), T(40)}, ZeroRequest::none);
  };
  EXPECT_EQ(step().torque, T(40));
  this->receive(T(-100), true);
  EXPECT_EQ(step().torque, T(-60));
}

TYPED_TEST(CommandSupervisionOf, ARestartSetsTheReferenceToZero) {
  using T = TypeParam;
  this->supervision = CommandSupervision<T>{{.torque_rate = T(1000)}};
  this->receive(T(0), false);
  this->step();
  this->receive(T(10), true);
  EXPECT_EQ(this->run(15 * ms).torque, T(10));
  this->supervision.restart();
  const auto out = this->step();
  EXPECT_TRUE(out.enable);
  EXPECT_NEAR(out.torque, T(0.025), T(1e-6));
}

TYPED_TEST(CommandSupervisionOf, WindingDownBringsTorqueToExactlyZeroAndHoldsItThere) {
  using T = TypeParam;
  this->start(T(77));
  this->zero = ZeroRequest::shutdown;
  EXPECT_EQ(this->run(10 * ms + 2 * period_ns).torque, T(0));
  this->receive(T(100), true);
  EXPECT_EQ(this->run(ms).torque, T(0));
}

TYPED_TEST(CommandSupervisionOf, AnInvalidEndToEndStateIsAFaultAndLocks) {
  this->start(TypeParam(15));
  this->command.e2e = E2eState::invalid;
  const auto out = this->step();
  EXPECT_TRUE(out.faults.test(Fault::command_invalid));
  EXPECT_TRUE(out.lockout);
  EXPECT_FALSE(out.enable);
}

TYPED_TEST(CommandSupervisionOf, OnlyAValidEndToEndStateUnlocks) {
  using T = TypeParam;
  for (const E2eState state : {E2eState::no_data, E2eState::init, E2eState::invalid}) {
    this->receive(T(0), false);
    this->command.e2e = state;
    EXPECT_TRUE(this->step().lockout);
    this->receive(T(0), true);
    this->command.e2e = state;
    EXPECT_FALSE(this->step().enable);
  }
}

TYPED_TEST(CommandSupervisionOf, BusOffIsAFaultAndNothingIsEnabledWhileItLasts) {
  using T = TypeParam;
  this->start(T(15));
  this->command.bus_off = true;
  const auto out = this->step();
  EXPECT_TRUE(out.faults.test(Fault::bus_off));
  EXPECT_FALSE(out.enable);
}

TYPED_TEST(CommandSupervisionOf, RefusesParametersThatCannotProtect) {
  using T = TypeParam;
  using Parameters = typename TestFixture::Limits;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), this->nan, std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.torque_limit = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.torque_rate = bad}.validate()), nullptr);
  }
  EXPECT_NE((Parameters{.timeout_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.zero_ramp_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.lost_ns = 1}.validate()), nullptr);
  EXPECT_NE((Parameters{.blocked_limit = 0}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
