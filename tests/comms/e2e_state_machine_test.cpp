#include "sextant/comms/e2e_state_machine.hpp"

#include <string_view>

#include <gtest/gtest.h>

namespace sextant {
namespace {

/// Feeds results (o = OK, e = error, c = counter error) and returns the state after each: N, I, V or X.
std::string states_after(std::string_view results, E2eStateMachine machine = {}) {
  std::string states;
  for (const char c : results) {
    machine.add(c == 'o'   ? E2eStateMachine::Status::ok
                : c == 'e' ? E2eStateMachine::Status::error
                           : E2eStateMachine::Status::neutral);
    states += "NIVX"[std::size_t(machine.state())];
  }
  return states;
}

TEST(E2eStateMachine, BecomesValidWithThreeOkAndNoError) {
  EXPECT_EQ(states_after("ooo"), "IIV");
  EXPECT_EQ(states_after("ococco"), "IIIIIV");
}

TEST(E2eStateMachine, ErrorsAloneDoNotLeaveNoData) {
  EXPECT_EQ(states_after("eeeeeeeeeeee"), "NNNNNNNNNNNN");
}

TEST(E2eStateMachine, AnErrorInTheWindowDelaysValidity) {
  // The error at place 2 leaves the window of ten at place 12.
  EXPECT_EQ(states_after("oeoooooooooo"), "IIIIIIIIIIIV");
}

TEST(E2eStateMachine, ThreeErrorsInTheWindowInvalidate) {
  EXPECT_EQ(states_after("oooeee"), "IIVVVX");
  EXPECT_EQ(states_after("oooeoeoe"), "IIVVVVVX");
  EXPECT_EQ(states_after("oeee"), "IIIX");
}

TEST(E2eStateMachine, TwoErrorsInTheWindowDoNot) {
  // Errors nine places apart from the next but one: never three within ten results.
  EXPECT_EQ(states_after("ooo"
                         "eeoooooooo"
                         "eeoooooooo"),
            "IIV"
            "VVVVVVVVVV"
            "VVVVVVVVVV");
}

TEST(E2eStateMachine, RecoversWhenTheErrorsHaveLeftTheWindow) {
  // INVALID at place 6; the last error leaves after ten more results, by when ten are OK.
  EXPECT_EQ(states_after("oooeeeoooooooooo"), "IIVVVXXXXXXXXXXV");
}

TEST(E2eStateMachine, RecoveryNeedsFiveOk) {
  // The errors have left by the tenth counter error; then five OK are needed.
  EXPECT_EQ(states_after("oooeee"
                         "cccccccccc"
                         "ooooo"),
            "IIVVVX"
            "XXXXXXXXXX"
            "XXXXV");
}

TEST(E2eStateMachine, CounterErrorsNeverInvalidate) {
  EXPECT_EQ(states_after("ooocccccccccccccccccccc"), "IIVVVVVVVVVVVVVVVVVVVVV");
}

TEST(E2eStateMachine, TakesItsWindowFromItsParameters) {
  const E2eStateMachine machine({.window = 5, .min_ok_init = 1, .max_error_valid = 0, .min_ok_invalid = 2});
  EXPECT_EQ(states_after("ooeooooo", machine), "IVXXXXXV");
}

}  // namespace
}  // namespace sextant
