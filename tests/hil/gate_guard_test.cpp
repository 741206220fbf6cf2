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
    const CommandRecord c{++sequence, t_ns, to_record(pattern), generation, 1};
    return period(&c, enabled);
  }
  /// One period without.
  GatePattern nothing(bool enabled = true) { return period(nullptr, enabled); }

  GatePattern period(const CommandRecord* c, bool enabled) {
    const GatePattern acts = guard.step(t_ns, c, enabled, present);
    t_ns += period_ns;
    return acts;
  }

  GateGuard guard{{.period_ns = period_ns, .hold_periods = 2, .silence_ns = 5'000'000}};
  std::int64_t t_ns{7'000'000'000};
  std::uint64_t sequence{0};
  std::uint32_t generation{1};
  bool present{true};
};

TEST_F(GateGuardTest, StaysOpenUntilADriveWrites) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::absent);
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.cause(), GateCause::following);
  EXPECT_EQ(guard.counters().drives, 1U);
}

TEST_F(GateGuardTest, HoldsALatePatternAsLongAsItMayAndThenOpens) {
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(nothing(), v1) << "the second period of two";
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::late);
  EXPECT_EQ(nothing(), open) << "an open gate stays open without a fresh pattern";
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.counters().late, 1U);
  EXPECT_EQ(guard.counters().held, 1U);
}

TEST_F(GateGuardTest, ADriveThatIsSilentForLongerThanTheLimitIsDead) {
  (void)command(v1);
  const std::int64_t last_ns = t_ns - period_ns;
  while (guard.cause() != GateCause::silent) {
    ASSERT_LT(t_ns - last_ns, 6'000'000);
    (void)nothing();
  }
  EXPECT_EQ(t_ns - period_ns - last_ns, 5'100'000) << "the first period beyond 5 ms";
  EXPECT_EQ(guard.open_since_ns() - last_ns, 2 * period_ns) << "they opened when the pattern was late";
  EXPECT_EQ(guard.heard_ns(), last_ns);
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.counters().silent, 1U);
}

TEST_F(GateGuardTest, OpensAtOnceWhenTheLineGoesOffWhateverIsWritten) {
  (void)command(v1);
  EXPECT_EQ(command(v1, false), open);
  EXPECT_EQ(guard.cause(), GateCause::disabled);
  EXPECT_EQ(nothing(), open) << "the line alone brings nothing back";
  EXPECT_EQ(command(v1), v1);
  EXPECT_EQ(guard.counters().disabled, 1U);
}

TEST_F(GateGuardTest, OpensAtOnceWhenTheDriveLeaves) {
  (void)command(v1);
  present = false;
  EXPECT_EQ(nothing(), open);
  EXPECT_EQ(guard.cause(), GateCause::absent);
}

TEST_F(GateGuardTest, ANewDriveIsRecognisedAndItsCountBeginsAnew) {
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

TEST_F(GateGuardTest, APatternThatDescribesNoneOpensTheGates) {
  CommandRecord bad{1, t_ns, to_record(v1), 1, 1};
  bad.pattern.count = 9;
  EXPECT_EQ(period(&bad, true), open);
  bad = {2, t_ns, to_record(v1), 1, 1};
  bad.pattern.legs[0] = 0b001'001;  // a leg both off and on
  EXPECT_EQ(period(&bad, true), open);
  EXPECT_EQ(guard.counters().unreadable, 2U);
}

TEST_F(GateGuardTest, AnEmptyPatternIsGatesOffForAPeriod) {
  EXPECT_EQ(command(GatePattern{}), open);
}

}  // namespace
}  // namespace sextant
