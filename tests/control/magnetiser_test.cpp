#include "sextant/control/magnetiser.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"

namespace sextant {
namespace {

template <class T>
class MagnetiserOf : public testing::Test {
 protected:
  Magnetiser<T> magnetiser{{.current_limit = T(40), .hand_over_current = T(30)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(MagnetiserOf, Scalars);

TYPED_TEST(MagnetiserOf, DrivesUntilTheLimitAndRestsUntilATenthBelowIt) {
  using T = TypeParam;
  EXPECT_EQ(this->magnetiser.step(T(0), T(1.1), T(0)), switch_states[1]);
  EXPECT_EQ(this->magnetiser.step(T(0.1), T(1.1), T(39.9)), switch_states[1]);
  EXPECT_EQ(this->magnetiser.step(T(0.1), T(1.1), T(40)), switch_states[0]);
  EXPECT_EQ(this->magnetiser.step(T(0.1), T(1.1), T(37)), switch_states[0]);
  EXPECT_EQ(this->magnetiser.step(T(0.1), T(1.1), T(35.9)), switch_states[1]);
  EXPECT_EQ(this->magnetiser.step(T(0.1), T(1.1), T(37)), switch_states[1]);
  EXPECT_FALSE(this->magnetiser.done());
}

TYPED_TEST(MagnetiserOf, IsDoneWhenTheFluxWasReachedAndTheCurrentHasDiedDown) {
  using T = TypeParam;
  EXPECT_EQ(this->magnetiser.step(T(1.1), T(1.1), T(38)), switch_states[0]);
  EXPECT_FALSE(this->magnetiser.done());
  // The flux sags a little while the current dies; it was reached nevertheless.
  EXPECT_EQ(this->magnetiser.step(T(1.09), T(1.1), T(30)), switch_states[0]);
  EXPECT_TRUE(this->magnetiser.done());
  this->magnetiser.reset();
  EXPECT_FALSE(this->magnetiser.done());
  EXPECT_EQ(this->magnetiser.step(T(1.0), T(1.1), T(0)), switch_states[1]);
}

TYPED_TEST(MagnetiserOf, MagnetisesADeadMachineAtStandstillWithoutASurge) {
  using T = TypeParam;
  test::ReferenceMachine machine;
  double peak = 0;
  int periods = 0;
  for (; periods < 8000 && !this->magnetiser.done(); ++periods) {
    const auto state = this->magnetiser.step(T(std::abs(machine.psi_s)), T(1.1), T(std::abs(machine.i_s())));
    machine.apply(GatePattern{state, 25'000});
    peak = std::max(peak, std::abs(machine.i_s()));
    EXPECT_NEAR(machine.torque(), 0, 1e-9);
  }
  EXPECT_TRUE(this->magnetiser.done());
  // One period at 2/3 of 530 V across σL_s adds at most 1.9 A to the limit.
  EXPECT_LT(peak, 42);
  EXPECT_GT(std::abs(machine.psi_s), 0.98 * 1.1);
  EXPECT_LE(std::abs(machine.i_s()), 30);
  EXPECT_LT(periods * 25e-6, 0.06);
}

TYPED_TEST(MagnetiserOf, RefusesCurrentsThatAreNone) {
  using T = TypeParam;
  using Parameters = typename Magnetiser<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.current_limit = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.hand_over_current = bad}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
