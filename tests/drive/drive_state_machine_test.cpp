#include "sextant/drive/drive_state_machine.hpp"

#include <set>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr int state_count = 8;

/// Calls check(state, conditions, next) for every state under every combination of conditions.
template <class Check>
void for_all(const Check& check) {
  for (int s = 0; s < state_count; ++s) {
    for (unsigned bits = 0; bits < 512; ++bits) {
      const auto bit = [bits](unsigned i) { return ((bits >> i) & 1U) != 0; };
      const DriveConditions c{.supplied = !bit(8),
                              .trip = bit(0),
                              .fault_reset = bit(1),
                              .shutdown = bit(2),
                              .at_zero = bit(3),
                              .lockout = bit(4),
                              .enable = bit(5),
                              .magnetised = bit(6),
                              .derated = bit(7)};
      const auto state = static_cast<DriveState>(s);
      SCOPED_TRACE(testing::Message() << to_string(state) << ", conditions " << bits);
      check(state, c, next_state(state, c));
    }
  }
}

TEST(DriveStateMachine, ATripTurnsTheGatesOffInEveryState) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    if (!c.trip) return;
    const bool leaving = state == DriveState::shutdown || c.shutdown;
    EXPECT_EQ(next, leaving ? DriveState::shutdown : DriveState::fault);
  });
}

TEST(DriveStateMachine, GatesAreNeverOnWhileTrippedLockedOutOrWithoutEnable) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    if (!gates_are_on(next)) return;
    EXPECT_FALSE(c.trip);
    EXPECT_FALSE(c.lockout);
    EXPECT_TRUE(c.enable);
    // They come on from READY only, so a period with the gates off and the lockout lifted lies before.
    EXPECT_TRUE(gates_are_on(state) || state == DriveState::ready);
  });
}

TEST(DriveStateMachine, WithoutVoltageTheGatesDoNotComeOnAndStayOn) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    DriveConditions charged = c;
    charged.supplied = true;
    const DriveState then = next_state(state, charged);
    if (c.supplied || gates_are_on(state)) {
      EXPECT_EQ(next, then);
    } else if (then == DriveState::ready || gates_are_on(then)) {
      EXPECT_EQ(next, DriveState::standby);
    } else {
      EXPECT_EQ(next, then);
    }
  });
}

TEST(DriveStateMachine, AFaultIsLeftOnlyByAResetOrForGood) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    if (state != DriveState::fault || next == DriveState::fault) return;
    if (next == DriveState::shutdown) {
      EXPECT_TRUE(c.shutdown);
    } else {
      EXPECT_FALSE(c.trip);
      EXPECT_TRUE(c.fault_reset);
      EXPECT_EQ(next, DriveState::standby);
    }
  });
}

TEST(DriveStateMachine, ShutdownIsForGood) {
  for_all([](DriveState state, const DriveConditions&, DriveState next) {
    if (state == DriveState::shutdown) {
      EXPECT_EQ(next, DriveState::shutdown);
    }
  });
}

TEST(DriveStateMachine, AShutdownWaitsForZeroTorqueOnlyWhileTheGatesAreOn) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    if (!c.shutdown) return;
    if (!gates_are_on(state) || c.at_zero || c.trip) {
      EXPECT_EQ(next, DriveState::shutdown);
    }
    if (gates_are_on(next)) {
      EXPECT_FALSE(c.at_zero);
    }
  });
}

TEST(DriveStateMachine, NothingReturnsToInit) {
  for_all([](DriveState, const DriveConditions&, DriveState next) { EXPECT_NE(next, DriveState::init); });
}

TEST(DriveStateMachine, MagnetisingEndsInTorqueAndTorqueNeverFallsBackToIt) {
  for_all([](DriveState state, const DriveConditions& c, DriveState next) {
    if (next == DriveState::magnetising) {
      EXPECT_FALSE(c.magnetised);
      EXPECT_TRUE(state == DriveState::ready || state == DriveState::magnetising);
    }
    if (next == DriveState::derated || next == DriveState::torque) {
      EXPECT_EQ(next == DriveState::derated, c.derated);
      EXPECT_TRUE(c.magnetised || state == DriveState::torque || state == DriveState::derated);
    }
  });
}

// Whatever happens, without a lockout lifted once the gates stay off: all states reachable under lockout.
TEST(DriveStateMachine, FromPowerUpTheGatesStayOffAsLongAsTheLockoutLasts) {
  std::set<DriveState> reachable{DriveState::init};
  for (std::size_t before = 0; before != reachable.size();) {
    before = reachable.size();
    for_all([&](DriveState state, const DriveConditions& c, DriveState next) {
      if (c.lockout && reachable.count(state) > 0) reachable.insert(next);
    });
  }
  for (const DriveState state : reachable) EXPECT_FALSE(gates_are_on(state)) << to_string(state);
}

TEST(DriveStateMachine, TheOrdinaryWayLeadsFromInitToTorque) {
  DriveConditions c;
  DriveState state = next_state(DriveState::init, c);
  EXPECT_EQ(state, DriveState::standby);
  EXPECT_EQ(next_state(state, c), DriveState::standby);
  c.lockout = false;
  state = next_state(state, c);
  EXPECT_EQ(state, DriveState::ready);
  c.enable = true;
  state = next_state(state, c);
  EXPECT_EQ(state, DriveState::magnetising);
  EXPECT_EQ(next_state(state, c), DriveState::magnetising);
  c.magnetised = true;
  state = next_state(state, c);
  EXPECT_EQ(state, DriveState::torque);
  c.derated = true;
  state = next_state(state, c);
  EXPECT_EQ(state, DriveState::derated);
  c.enable = false;
  EXPECT_EQ(next_state(state, c), DriveState::ready);
}

}  // namespace
}  // namespace sextant
