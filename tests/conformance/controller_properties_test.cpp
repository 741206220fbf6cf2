// What every control method does, closed around the reference machine.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "conformance/types_of.hpp"
#include "control/controller_loop.hpp"
#include "sextant/config/control_methods.hpp"

namespace sextant {
namespace {

using test::Loop;
using test::parameters;
using test::psi_ref;

template <class C>
class ControllerProperties : public testing::Test {};
TYPED_TEST_SUITE(ControllerProperties, test::TypesOf<ControllerList<double>>::Types);

template <class C>
struct InFloat;
template <template <class> class C>
struct InFloat<C<double>> {
  using Type = C<float>;
};

/// Magnetised, then steps of torque at one speed: the torque at the end of every period. [N·m]
template <class C>
std::vector<double> torques(double sign, double omega_m) {
  Loop<C> loop{parameters<C>()};
  loop.machine.omega_m = sign * omega_m;
  loop.magnetise();
  std::vector<double> list;
  for (const double torque : {15.0, 60.0, -40.0}) {
    for (int k = 0; k < 400; ++k) list.push_back(loop.step(ControlMode::torque, sign * torque));
  }
  return list;
}

// Phases b and c swapped turn speed and torque into their opposites, and nothing else.
TYPED_TEST(ControllerProperties, IsSymmetricUnderReversalOfDirectionAndTorque) {
  for (const double omega_m : {0.0, 10.0, 75.0, 250.0}) {
    const std::vector<double> forwards = torques<TypeParam>(1, omega_m);
    const std::vector<double> backwards = torques<TypeParam>(-1, omega_m);
    for (std::size_t k = 0; k < forwards.size(); ++k) {
      ASSERT_NEAR(forwards[k], -backwards[k], 1e-6) << omega_m << " rad/s, period " << k;
    }
  }
}

// A decision that differs for a rounding error changes a period, and not the mean or the ripple.
TYPED_TEST(ControllerProperties, FloatAgreesWithDouble) {
  using Float = typename InFloat<TypeParam>::Type;
  for (const double omega_m : {5.0, 75.0, -110.0}) {
    for (const double torque : {2.0, 60.0}) {
      Loop<TypeParam> in_double{parameters<TypeParam>()};
      Loop<Float> in_float{parameters<Float>()};
      const auto settled = [&](auto& loop) {
        loop.machine.omega_m = omega_m;
        loop.magnetise();
        loop.run(ControlMode::torque, torque, 200);
        return loop.ripple(torque, 100, psi_ref);
      };
      const auto a = settled(in_double);
      const auto b = settled(in_float);
      EXPECT_NEAR(a.bias, b.bias, 0.05) << torque << " at " << omega_m;
      EXPECT_NEAR(a.rms, b.rms, 0.02 + 0.05 * a.rms) << torque << " at " << omega_m;
    }
  }
}

}  // namespace
}  // namespace sextant
