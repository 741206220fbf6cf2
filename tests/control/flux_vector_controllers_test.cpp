// What the control methods do that choose one pattern of a set, closed around the reference machine.
#include <cmath>

#include <gtest/gtest.h>

#include "control/controller_loop.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/predictive_controller.hpp"

namespace sextant {
namespace {

using test::Loop;
using test::parameters;
using test::psi_ref;
using test::Scalar;

template <class C>
class FluxVectorControllers : public testing::Test {};
using Controllers = testing::Types<PredictiveController<float>, PredictiveController<double>,
                                   DutyRatioController<float>, DutyRatioController<double>>;
TYPED_TEST_SUITE(FluxVectorControllers, Controllers);

/// Torque within periods against its reference in a steady state, at 25 µs and 530 V. [N·m]
template <class C>
struct Bounds;
// A whole period of an active vector changes the torque by 5.9 N·m.
template <class T>
struct Bounds<PredictiveController<T>> {
  static constexpr double worst = 3.8, rms = 1.6, bias = 0.1, flux_wb = 0.0055;
};
template <class T>
struct Bounds<DutyRatioController<T>> {
  static constexpr double worst = 2.6, rms = 0.8, bias = 0.1, flux_wb = 0.0045;
};

TYPED_TEST(FluxVectorControllers, TorqueAndFluxMeetTheirReferences) {
  using Bound = Bounds<TypeParam>;
  for (const int delay : {0, 1}) {
    for (const double omega_m : {0.0, 5.0, -20.0, 75.0, 110.0, -110.0}) {
      for (const double torque : {-130.0, -2.0, 0.0, 15.0, 130.0}) {
        SCOPED_TRACE(testing::Message() << torque << " at " << omega_m << ", delay " << delay);
        Loop<TypeParam> loop{parameters<TypeParam>(delay)};
        loop.machine.omega_m = omega_m;
        ASSERT_GT(loop.magnetise(), 0);
        loop.run(ControlMode::torque, torque, 200);
        const auto r = loop.ripple(torque, 50, psi_ref);
        EXPECT_LE(r.worst, Bound::worst);
        EXPECT_LE(r.rms, Bound::rms);
        EXPECT_LE(std::abs(r.bias), Bound::bias);
        EXPECT_LE(r.worst_flux, Bound::flux_wb);
      }
    }
  }
}

// Without magnetising first. A whole period of an active vector adds 1.9 A.
TYPED_TEST(FluxVectorControllers, StartsWithinItsCurrentLimit) {
  for (const double limit : {20.0, 40.0}) {
    auto p = parameters<TypeParam>();
    p.current_limit = Scalar<TypeParam>(limit);
    Loop<TypeParam> loop{p};
    double t_ms = 0;
    while (loop.step(ControlMode::torque, 15) < 0.95 * 15) {
      t_ms += 0.025;
      ASSERT_LT(t_ms, 30);
    }
    EXPECT_NEAR(loop.run(ControlMode::torque, 15, 300), 15, 0.75);
    EXPECT_LE(loop.peak_current, limit + 1.9);
  }
}

// One active vector, in the middle of a zero vector that switches one leg.
TYPED_TEST(FluxVectorControllers, OnePulseAPeriod) {
  Loop<TypeParam> loop{parameters<TypeParam>()};
  loop.machine.omega_m = 60;
  loop.magnetise();
  loop.step(ControlMode::torque, 30);  // the pattern before is one of magnetising
  for (int k = 0; k < 1000; ++k) {
    loop.step(ControlMode::torque, 30);
    const auto segments = loop.applied().segments();
    ASSERT_LE(segments.size(), 3U);
    if (segments.size() < 3) continue;
    EXPECT_EQ(segments[0].state, segments[2].state);
    EXPECT_EQ(commutations(segments[0].state, segments[1].state), 1);
    EXPECT_LE(std::abs(segments[0].duration_ns - segments[2].duration_ns), 1);
  }
}

TYPED_TEST(FluxVectorControllers, RefusesACurrentLimitThatCannotMagnetise) {
  auto p = parameters<TypeParam>();
  EXPECT_EQ(p.validate(), nullptr);
  p.current_limit = Scalar<TypeParam>(12);  // 12.8 A magnetise the machine
  EXPECT_NE(p.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
