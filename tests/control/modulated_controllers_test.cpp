// What every control method with a space-vector modulator does, closed around the reference machine.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "control/controller_loop.hpp"
#include "sextant/control/deadbeat_controller.hpp"
#include "sextant/control/feedback_linearisation_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"
#include "sextant/control/modulated_controller.hpp"
#include "sextant/control/pwm_dtc_controller.hpp"

namespace sextant {
namespace {

using test::Loop;
using test::parameters;
using test::psi_ref;
using test::Scalar;

/// How far a method may miss a limit or a reference on the way.
template <class C>
struct Bounds {
  double current{1.005};  ///< largest current, by its limit [-]
  double return_nm{1.0};  ///< deviation of the torque 3 ms after the voltage limit [N·m]
};
template <class T>
struct Bounds<FeedbackLinearisationController<T>> {
  double current{1.005};
  double return_nm{2.0};
};
// The integrals of torque and flux know of no current.
template <class T>
struct Bounds<PwmDtcController<T>> {
  double current{1.08};
  double return_nm{5.0};
};

template <class C>
class ModulatedControllers : public testing::Test {};
using Controllers =
    testing::Types<DeadbeatController<float>, DeadbeatController<double>, FieldOrientedController<float>,
                   FieldOrientedController<double>, FeedbackLinearisationController<float>,
                   FeedbackLinearisationController<double>, PwmDtcController<float>,
                   PwmDtcController<double>>;
TYPED_TEST_SUITE(ModulatedControllers, Controllers);

// 25 µs, wherever the voltage of the steady state is within u_dc/√3. The ripple is that of the modulation.
TYPED_TEST(ModulatedControllers, TorqueAndFluxMeetTheirReferences) {
  for (const int delay : {0, 1}) {
    for (const double omega_m : {0.0, 5.0, -20.0, 75.0, 110.0, -110.0}) {
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

// Without magnetising first the flux that the torque needs has priority. The bounds of these limits are 17.9
// and 4.1 ms: ψ_r has to reach T/(3/2 p k_r i_q).
TYPED_TEST(ModulatedControllers, StartsWithinItsCurrentLimit) {
  struct Start {
    double limit;
    double longest_ms;
  };
  for (const Start start : {Start{20, 22}, Start{40, 6}}) {
    auto p = parameters<TypeParam>();
    p.current_limit = Scalar<TypeParam>(start.limit);
    Loop<TypeParam> loop{p};
    double t_ms = 0;
    while (loop.step(ControlMode::torque, 15) < 0.95 * 15) {
      t_ms += 0.025;
      ASSERT_LT(t_ms, 100);
    }
    EXPECT_LE(t_ms, start.longest_ms);
    EXPECT_NEAR(loop.run(ControlMode::torque, 15, 300), 15, 0.75);
    EXPECT_LE(loop.peak_current, Bounds<TypeParam>{}.current * start.limit);
  }
}

TYPED_TEST(ModulatedControllers, TheCurrentStaysWithinItsLimitWhateverIsCommanded) {
  auto p = parameters<TypeParam>();
  p.current_limit = Scalar<TypeParam>(40);
  Loop<TypeParam> loop{p};
  loop.machine.omega_m = 60;
  loop.magnetise();
  for (const double torque : {500.0, -500.0, 0.0, 300.0}) {
    loop.peak_current = 0;
    loop.run(ControlMode::torque, torque, 50);
    EXPECT_LE(loop.peak_current, Bounds<TypeParam>{}.current * 40) << torque;
  }
  // The rest of 40 A across a rotor flux of L_m times what holds it.
  EXPECT_GT(loop.run(ControlMode::torque, 500, 300), 100);
}

// As flux weakening asks for it; τ_r is 105 ms, σ τ_r 6 ms. The first millisecond changes i_d by 70 A.
TYPED_TEST(ModulatedControllers, TheFluxFollowsFasterThanTheRotorTimeConstantAtTheSameTorque) {
  Loop<TypeParam> loop{parameters<TypeParam>()};
  loop.machine.omega_m = 50;
  loop.magnetise();
  loop.run(ControlMode::torque, 30, 200);
  for (const double share : {0.7, 1.0}) {
    loop.flux_share = share;
    loop.run(ControlMode::torque, 30, 1);
    for (int k = 1; k < 30; ++k) EXPECT_NEAR(loop.run(ControlMode::torque, 30, 1), 30, 1.0) << k << " ms";
    EXPECT_NEAR(std::abs(loop.machine.psi_s), share * psi_ref, 0.01 * psi_ref);
    EXPECT_NEAR(std::abs(loop.machine.psi_r), share * psi_ref * 0.97, 0.02 * psi_ref);
  }
}

// Beyond the hexagon the nearest voltage. With an integral that had wound up the way back would take longer
// than the current needs at that voltage.
TYPED_TEST(ModulatedControllers, ComesBackFromTheVoltageLimitWithoutWindUp) {
  Loop<TypeParam> loop{parameters<TypeParam>()};
  loop.machine.omega_m = 100;
  loop.magnetise();
  loop.run(ControlMode::torque, 60, 100);
  loop.machine.omega_m = 200;
  loop.run(ControlMode::torque, 60, 100);
  loop.machine.omega_m = 100;
  loop.run(ControlMode::torque, 60, 3);
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    worst = std::max(worst, std::abs(loop.step(ControlMode::torque, 60) - 60));
  }
  EXPECT_LE(worst, Bounds<TypeParam>{}.return_nm);
  EXPECT_NEAR(loop.run(ControlMode::torque, 60, 400), 60, 0.1);
}

TYPED_TEST(ModulatedControllers, RefusesParametersThatCannotWork) {
  using T = Scalar<TypeParam>;
  using Parameters = typename TypeParam::Parameters;
  const auto refused = [](auto change) {
    Parameters p = parameters<TypeParam>();
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
