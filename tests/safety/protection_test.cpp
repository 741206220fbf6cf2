#include "sextant/safety/protection.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class ProtectionOf : public testing::Test {
 protected:
  static constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  static constexpr T infinity = std::numeric_limits<T>::infinity();

  [[nodiscard]] static Measurement<T> healthy() {
    Measurement<T> m;
    m.i_abc = {T(50), T(-20), T(-30)};
    m.u_dc = T(530);
    m.omega_m = T(100);
    return m;
  }
  [[nodiscard]] static FaultSet only(Fault f) {
    FaultSet set;
    set.set(f);
    return set;
  }
  Protection<T> protection{{.over_current = T(200), .dc_over_voltage = T(700), .over_speed = T(160)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ProtectionOf, Scalars);

TYPED_TEST(ProtectionOf, AHealthyMeasurementShowsNoFault) {
  EXPECT_TRUE(Protection<TypeParam>::is_usable(this->healthy()));
  EXPECT_FALSE(this->protection.step(this->healthy()).any());
}

TYPED_TEST(ProtectionOf, OverCurrentIsSeenInEachPhaseAndSign) {
  using T = TypeParam;
  for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) {
    for (const T sign : {T(-1), T(1)}) {
      Measurement<T> m = this->healthy();
      m.i_abc.*phase = sign * T(200);
      EXPECT_FALSE(this->protection.step(m).any());
      m.i_abc.*phase = sign * T(200.1);
      EXPECT_EQ(this->protection.step(m), this->only(Fault::over_current));
    }
  }
}

TYPED_TEST(ProtectionOf, OverVoltageIsSeenAboveItsLevel) {
  using T = TypeParam;
  Measurement<T> m = this->healthy();
  m.u_dc = T(700);
  EXPECT_FALSE(this->protection.step(m).any());
  m.u_dc = T(700.1);
  EXPECT_EQ(this->protection.step(m), this->only(Fault::dc_over_voltage));
}

TYPED_TEST(ProtectionOf, OverSpeedIsSeenBothWays) {
  using T = TypeParam;
  for (const T sign : {T(-1), T(1)}) {
    Measurement<T> m = this->healthy();
    m.omega_m = sign * T(160);
    EXPECT_FALSE(this->protection.step(m).any());
    m.omega_m = sign * T(160.1);
    EXPECT_EQ(this->protection.step(m), this->only(Fault::over_speed));
  }
}

TYPED_TEST(ProtectionOf, EveryNumberMustBeFinite) {
  using T = TypeParam;
  for (const T bad : {this->nan, this->infinity, -this->infinity}) {
    for (int which = 0; which < 6; ++which) {
      Measurement<T> m = this->healthy();
      m.theta_m = T(1);
      EXPECT_FALSE(this->protection.step(m).any());
      T* const numbers[] = {&m.i_abc.a, &m.i_abc.b, &m.i_abc.c, &m.u_dc, &m.omega_m, &*m.theta_m};
      *numbers[which] = bad;
      EXPECT_FALSE(Protection<T>::is_usable(m));
      EXPECT_EQ(this->protection.step(m), this->only(Fault::measurement_invalid)) << which;
    }
  }
}

TYPED_TEST(ProtectionOf, AnUnansweredReadIsAFault) {
  Measurement<TypeParam> m = this->healthy();
  m.plausible = false;
  EXPECT_EQ(this->protection.step(m), this->only(Fault::measurement_invalid));
}

TYPED_TEST(ProtectionOf, RefusesTripLevelsThatAreNone) {
  using T = TypeParam;
  using Parameters = typename Protection<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), this->nan, this->infinity}) {
    EXPECT_NE((Parameters{.over_current = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.dc_over_voltage = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.over_speed = bad}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
