#include "sextant/drive/torque_capability.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class TorqueCapabilityOf : public testing::Test {
 protected:
  TorqueCapability<T> capability{{.torque = T(150), .base_speed = T(100), .zero_torque_speed = T(180)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueCapabilityOf, Scalars);

TYPED_TEST(TorqueCapabilityOf, MotoringTorqueFallsLinearlyBeyondTheBaseSpeed) {
  using T = TypeParam;
  const struct {
    T omega_m;
    T motoring;
  } cases[] = {{T(0), T(150)},  {T(99), T(150)}, {T(100), T(150)}, {T(120), T(112.5)},
               {T(140), T(75)}, {T(180), T(0)},  {T(500), T(0)}};
  for (const auto& x : cases) {
    for (const T sign : {T(-1), T(1)}) {
      EXPECT_NEAR(this->capability.at(sign * x.omega_m).motoring, x.motoring, T(1e-4));
      EXPECT_EQ(this->capability.at(sign * x.omega_m).regenerating, T(150));
    }
  }
}

TYPED_TEST(TorqueCapabilityOf, TheDirectionOfRotationDecidesWhichTorqueIsMotoring) {
  using T = TypeParam;
  const auto range = [this](T omega_m) { return this->capability.at(omega_m).range(omega_m); };
  EXPECT_EQ(range(T(140)).lowest, T(-150));
  EXPECT_NEAR(range(T(140)).highest, T(75), T(1e-4));
  EXPECT_NEAR(range(T(-140)).lowest, T(-75), T(1e-4));
  EXPECT_EQ(range(T(-140)).highest, T(150));
  EXPECT_EQ(range(T(0)).lowest, T(-150));
  EXPECT_EQ(range(T(0)).highest, T(150));
}

TYPED_TEST(TorqueCapabilityOf, RefusesACurveThatIsNone) {
  using T = TypeParam;
  using Parameters = typename TorqueCapability<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.torque = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.base_speed = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.zero_torque_speed = bad}.validate()), nullptr);
  }
  EXPECT_NE((Parameters{.base_speed = T(100), .zero_torque_speed = T(100)}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
