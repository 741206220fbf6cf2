#include "sextant/hil/gate_guard.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 100'000;
const GatePattern v1{switch_states[1], period_ns};
const GatePattern open{gates_off, period_ns};

class GateGuardTest : public testing::Test {
 protected:
  /// One period with a new command.
  GatePattern command(const GatePattern& pattern, bool enabled = true) {
    const DrivePatternRecord c{++sequence, t_ns, to_record(pattern), generation, 1};
    return period(&c, enabled);
  }
  /// One period without.
  GatePattern nothing(bool enabled = true) { return period(nullptr, enabled); }

  GatePattern period(const DrivePatternRecord* c, bool enabled) {
    const GatePattern acts = guard.step(t_ns, c, enabled, present);
    t_ns += period_ns;
    news += guard.is_reportable() ? 1 : 0;
    return acts;
  }
  /// Until the drive counts as dead.
  void fall_silent() {
    for (int n = 0; n < 60 && guard.cause() != GateCause::timed_out; ++n) (void)nothing();
    ASSERT_EQ(guard.cause(), GateCause::timed_out);
  }

  GateGuard guard{
      {.period_ns = period_ns, .hold_periods = 2, .pattern_timeout_ns = 5'000'000, .same_clock = true}};
  std::int64_t t_ns{7'000'000'000};
  std::uint64_t sequence{0};
  std::uint32_t generation{1};
  bool present{true};
  int news{0};
};

/// The same with a drive that has shown gates off, as each does long before it drives them.
class GateGuardOfAReadyDrive : public GateGuardTest {
 protected:
  GateGuardOfAReadyDrive() { (void)command(open); }
};

TEST_F(GateGuardTest, StaysOffUntilADriveWrites) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::absent);
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.cause(), GateCause::following);
  EXPECT_EQ(guard.counters().drives, 1U);
}

TEST_F(GateGuardTest, ADriveThatIsMetWhileItDrivesIsLockedOutUntilItShowsGatesOff) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(command(v1), open);
  EXPECT_EQ(guard.cause(), GateCause::locked_out);
  EXPECT_EQ(guard.counters().locked_out, 1U);
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(command(v1), v1);
}

TEST_F(GateGuardOfAReadyDrive, HoldsALatePatternAsLongAsItMayAndThenTurnsOff) {
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(nothing(), v1) << "the second period of two";
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::late);
  EXPECT_EQ(nothing(), open) << "gates stay off without a new pattern";
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.counters().late, 1U);
  EXPECT_EQ(guard.counters().held, 1U);
}

TEST_F(GateGuardOfAReadyDrive, ADriveWithoutPatternsForLongerThanTheLimitHasTimedOut) {
  (void)command(v1);
  const std::int64_t last_ns = t_ns - period_ns;
  while (guard.cause() != GateCause::timed_out) {
    ASSERT_LT(t_ns - last_ns, 6'000'000);
    (void)nothing();
  }
  EXPECT_EQ(t_ns - period_ns - last_ns, 5'100'000) << "the first period beyond 5 ms";
  EXPECT_EQ(guard.off_since_ns() - last_ns, 2 * period_ns) << "they opened when the pattern was late";
  EXPECT_EQ(guard.last_pattern_ns(), last_ns);
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.counters().timed_out, 1U);
}

// A drive that was stopped in the middle of a period writes a pattern of before when it goes on.
TEST_F(GateGuardOfAReadyDrive, AfterATimeoutTorquePatternsStayWithoutEffectUntilTheDriveHasShownGatesOff) {
  (void)command(v1);
  fall_silent();
  for (int i = 0; i < 100; ++i) ASSERT_EQ(command(v1), open) << i;
  EXPECT_EQ(guard.cause(), GateCause::locked_out);
  EXPECT_EQ(guard.counters().locked_out, 1U);
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.cause(), GateCause::following);
}

TEST_F(GateGuardOfAReadyDrive, APatternThatIsInvalidDoesNotShowGatesOff) {
  (void)command(v1);
  fall_silent();
  DrivePatternRecord bad{++sequence, t_ns, to_record(open), generation, 1};
  bad.pattern.count = 9;
  EXPECT_EQ(period(&bad, true), open);
  EXPECT_EQ(command(v1), open);
  EXPECT_EQ(guard.cause(), GateCause::locked_out);
}

TEST_F(GateGuardOfAReadyDrive, APatternOlderThanTheLimitIsNone) {
  (void)command(v1);
  (void)nothing();
  const std::int64_t age_ns = 5'000'000 + 2 * period_ns;  // a pattern is up to two periods under way
  DrivePatternRecord old{++sequence, t_ns - age_ns - 1, to_record(open), generation, 1};
  EXPECT_EQ(period(&old, true), open);
  EXPECT_EQ(guard.cause(), GateCause::late) << "as if nothing had come";
  EXPECT_EQ(guard.counters().outdated, 1U);
  EXPECT_EQ(guard.pattern_number(), sequence - 1) << "the drive is not told that it was heard";
  DrivePatternRecord just_in_time{++sequence, t_ns - age_ns, to_record(v1), generation, 1};
  EXPECT_EQ(period(&just_in_time, true), v1);
  EXPECT_EQ(guard.counters().outdated, 1U);
}

TEST_F(GateGuardOfAReadyDrive, APatternOfAnotherMachinesClockHasNoAge) {
  guard = GateGuard{{.period_ns = period_ns, .hold_periods = 2, .pattern_timeout_ns = 5'000'000}};
  const DrivePatternRecord far{++sequence, -1'000'000'000'000'000, to_record(open), generation, 1};
  (void)period(&far, true);
  EXPECT_EQ(guard.cause(), GateCause::following);
}

// A machine that stood still as a whole: the drive could not write, the plant could not look.
TEST_F(GateGuardOfAReadyDrive, TimeInWhichThePlantItselfWasStoppedDoesNotCount) {
  (void)command(v1);
  t_ns += 20'000'000;
  EXPECT_EQ(nothing(), open) << "the pattern's time is over all the same";
  EXPECT_EQ(guard.cause(), GateCause::late);
  EXPECT_EQ(guard.counters().timed_out, 0U);
  EXPECT_EQ(command(v1), v1);
}

TEST_F(GateGuardOfAReadyDrive, TurnsOffAtOnceWhenTheLineGoesOffWhateverIsWritten) {
  (void)command(v1);
  EXPECT_EQ(command(v1, false), open);
  EXPECT_EQ(guard.cause(), GateCause::disabled);
  EXPECT_EQ(nothing(), open) << "the line alone brings nothing back";
  EXPECT_EQ(command(v1), open) << "nor does a torque pattern";
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.counters().disabled, 1U);
}

TEST_F(GateGuardOfAReadyDrive, GatesOffThatTheDriveShowsJustBeforeItSetsTheLineCount) {
  (void)command(v1);
  (void)command(v1, false);
  EXPECT_EQ(command(open, false), open);
  EXPECT_EQ(nothing(false), open);
  EXPECT_EQ(command(v1), v1);
}

TEST_F(GateGuardOfAReadyDrive, TurnsOffAtOnceWhenTheDriveLeaves) {
  (void)command(v1);
  present = false;
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::absent);
  present = true;
  EXPECT_EQ(command(v1), open) << "another one has to show gates off first";
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(command(v1), v1);
}

TEST_F(GateGuardOfAReadyDrive, ANewDriveIsRecognisedAndItsCountBeginsAnew) {
  for (int i = 0; i < 10; ++i) (void)command(v1);
  generation = 2;
  sequence = 0;
  EXPECT_EQ(command(open), open);
  EXPECT_EQ(guard.counters().drives, 2U);
  EXPECT_EQ(guard.counters().missing, 0U);
  sequence += 3;
  (void)command(v1);
  EXPECT_EQ(guard.counters().missing, 3U);
}

TEST_F(GateGuardOfAReadyDrive, APatternThatIsInvalidTurnsTheGatesOff) {
  DrivePatternRecord bad{++sequence, t_ns, to_record(v1), 1, 1};
  bad.pattern.count = 9;
  EXPECT_EQ(period(&bad, true), open);
  bad = {++sequence, t_ns, to_record(v1), 1, 1};
  bad.pattern.legs[0] = 0b001'001;  // a leg both off and on
  EXPECT_EQ(period(&bad, true), open);
  EXPECT_EQ(guard.counters().unreadable, 2U);
}

TEST_F(GateGuardTest, ALineThatWasNeverOnDoesNotGoOff) {
  (void)nothing(false);
  (void)command(open, false);  // the drive sets the line right after its first pattern
  EXPECT_EQ(guard.cause(), GateCause::disabled);
  EXPECT_EQ(guard.counters().disabled, 0U);
  EXPECT_EQ(news, 0) << "nothing has changed for the gates";
  (void)command(open);
  EXPECT_EQ(guard.cause(), GateCause::following);
  EXPECT_EQ(news, 1);
  (void)command(open, false);
  EXPECT_EQ(guard.counters().disabled, 1U);
  EXPECT_EQ(news, 2);
}

TEST_F(GateGuardTest, TheLineOfADriveThatWasStartedAnewHasNotGoneOffEither) {
  (void)command(open);
  (void)command(v1);
  fall_silent();
  generation = 2;
  const int before = news;
  (void)command(open, false);
  EXPECT_EQ(guard.cause(), GateCause::disabled);
  EXPECT_EQ(guard.counters().disabled, 0U);
  EXPECT_EQ(news, before);
}

TEST_F(GateGuardOfAReadyDrive, AnEmptyPatternIsGatesOffForAPeriod) {
  EXPECT_EQ(command(GatePattern{}), open);
}

}  // namespace
}  // namespace sextant
