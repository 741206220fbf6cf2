// Deadbeat control closed around the reference machine, which is integrated within each pattern.
#include "sextant/control/deadbeat_controller.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "control/controlled_machine.hpp"

namespace sextant {
namespace {

template <class T>
using Loop = test::ControlledMachine<T, DeadbeatController<T>>;

template <class T>
typename DeadbeatController<T>::Parameters parameters(int delay = 1) {
  typename DeadbeatController<T>::Parameters p;
  p.actuation_delay_periods = delay;
  p.magnetiser = {.current_limit = T(40), .hand_over_current = T(30)};
  return p;
}

template <class T>
class DeadbeatControllerOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DeadbeatControllerOf, Scalars);

TYPED_TEST(DeadbeatControllerOf, AStepOfTorqueIsThereWhenTheVoltageHasBroughtIt) {
  for (const double torque : {60.0, -60.0}) {
    Loop<TypeParam> loop{parameters<TypeParam>()};
    loop.machine.omega_m = 50;
    loop.magnetise();
    loop.run(ControlMode::torque, 0, 200);
    int periods = 0;
    while (std::abs(loop.step(ControlMode::torque, torque) - torque) > 0.05 * std::abs(torque)) {
      ASSERT_LT(++periods, 100);
    }
    // 60 N·m are 19 A across the flux, at 4.7 mH and some 200 V.
    EXPECT_LE(periods * 25e-6, 0.6e-3);
    for (int k = 0; k < 200; ++k) {
      EXPECT_NEAR(loop.step(ControlMode::torque, torque), torque, 0.02 * std::abs(torque));
    }
  }
}

}  // namespace
}  // namespace sextant
