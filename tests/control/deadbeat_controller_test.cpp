// Deadbeat control closed around the reference machine, which is integrated within each pattern.
#include "sextant/control/deadbeat_controller.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "control/controlled_machine.hpp"

namespace sextant {
namespace {

constexpr double psi_ref = 1.1;

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

// 25 µs, one period of delay, wherever the voltage of the steady state is within u_dc/√3. The plain table has
// an RMS of 1.4 N·m at standstill and a bias of −2.3 N·m at 100 rad/s.
TYPED_TEST(DeadbeatControllerOf, TorqueAndFluxMeetTheirReferences) {
  for (const int delay : {0, 1}) {
    for (const double omega_m : {0.0, 5.0, -20.0, 75.0, -110.0}) {
      for (const double torque : {-130.0, -2.0, 0.0, 15.0, 130.0}) {
        SCOPED_TRACE(testing::Message() << torque << " at " << omega_m << ", delay " << delay);
        Loop<TypeParam> loop{parameters<TypeParam>(delay)};
        loop.machine.omega_m = omega_m;
        ASSERT_GT(loop.magnetise(), 0);
        loop.run(ControlMode::torque, torque, 200);
        const auto r = loop.ripple(torque, 50, psi_ref);
        EXPECT_LE(r.worst, 0.40);
        EXPECT_LE(r.rms, 0.21);
        EXPECT_LE(std::abs(r.bias), 0.04);
        EXPECT_LE(r.worst_flux, 0.002 * psi_ref);
      }
    }
  }
}

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

// Without magnetising first the flux that the torque needs has priority. The bounds of these limits are 17.9
// and 4.1 ms: ψ_r has to reach T/(3/2 p k_r i_q).
TYPED_TEST(DeadbeatControllerOf, StartsWithinItsCurrentLimit) {
  struct Start {
    double limit;
    double longest_ms;
  };
  for (const Start start : {Start{20, 22}, Start{40, 6}}) {
    auto p = parameters<TypeParam>();
    p.current_limit = TypeParam(start.limit);
    Loop<TypeParam> loop{p};
    double t_ms = 0;
    while (loop.step(ControlMode::torque, 15) < 0.95 * 15) {
      t_ms += 0.025;
      ASSERT_LT(t_ms, 100);
    }
    EXPECT_LE(t_ms, start.longest_ms);
    EXPECT_NEAR(loop.run(ControlMode::torque, 15, 300), 15, 0.75);
    EXPECT_LE(loop.peak_current, 1.005 * start.limit);
  }
}

TYPED_TEST(DeadbeatControllerOf, TheCurrentStaysWithinItsLimitWhateverIsCommanded) {
  auto p = parameters<TypeParam>();
  p.current_limit = TypeParam(40);
  Loop<TypeParam> loop{p};
  loop.machine.omega_m = 60;
  loop.magnetise();
  for (const double torque : {500.0, -500.0, 0.0, 300.0}) {
    loop.peak_current = 0;
    loop.run(ControlMode::torque, torque, 50);
    EXPECT_LE(loop.peak_current, 41) << torque;
  }
  // The rest of 40 A across a rotor flux of L_m times what holds it.
  EXPECT_GT(loop.run(ControlMode::torque, 500, 300), 100);
}

// Beyond the hexagon the nearest voltage: the flux gives way, and both come back.
TYPED_TEST(DeadbeatControllerOf, ComesBackFromTheVoltageLimit) {
  Loop<TypeParam> loop{parameters<TypeParam>()};
  loop.machine.omega_m = 100;
  loop.magnetise();
  loop.run(ControlMode::torque, 60, 100);
  loop.machine.omega_m = 200;
  loop.run(ControlMode::torque, 60, 100);
  loop.machine.omega_m = 100;
  EXPECT_NEAR(loop.run(ControlMode::torque, 60, 400), 60, 0.5);
  const auto r = loop.ripple(60, 20, psi_ref);
  EXPECT_LE(r.worst, 0.6);
}

TYPED_TEST(DeadbeatControllerOf, RefusesParametersThatCannotWork) {
  using T = TypeParam;
  using Parameters = typename DeadbeatController<T>::Parameters;
  const auto refused = [](auto change) {
    Parameters p = parameters<T>();
    change(p);
    return p.validate() != nullptr;
  };
  EXPECT_FALSE(refused([](Parameters&) {}));
  EXPECT_TRUE(refused([](Parameters& p) { p.period_ns = 0; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.current_limit = T(12); })) << "12.8 A magnetise the machine";
  EXPECT_TRUE(refused([](Parameters& p) { p.current_limit = std::numeric_limits<T>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.modulator.shortest_pulse_ns = -1; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.actuation_delay_periods = 2; }));
  EXPECT_TRUE(refused([](Parameters& p) { p.flux_reference = T(0); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.magnetiser.hand_over_current = T(12); }));
  EXPECT_TRUE(refused([](Parameters& p) { p.machine.l_m = T(-1); }));
}

}  // namespace
}  // namespace sextant
