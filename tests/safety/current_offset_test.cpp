#include "sextant/safety/current_offset.hpp"

#include <gtest/gtest.h>

#include "sextant/safety/protection.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 25'000;
constexpr int average_periods = 800;  // 20 ms
constexpr int rest_periods = 400;     // 10 ms

template <class T>
class CurrentOffsetOf : public testing::Test {
 protected:
  [[nodiscard]] static Measurement<T> reading(T a, T b, T c, SwitchState state = gates_off) {
    Measurement<T> m;
    m.i_abc = {a, b, c};
    m.u_dc = T(530);
    m.applied = GatePattern{state, period_ns};
    return m;
  }
  void run(const Measurement<T>& m, int periods) {
    for (int k = 0; k < periods; ++k) offset.step(m);
  }

  static constexpr T limit = T(0.58);
  CurrentOffset<T> offset{{.limit = limit}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CurrentOffsetOf, Scalars);

TYPED_TEST(CurrentOffsetOf, IsTheMeanReadingWithTheGatesOff) {
  using T = TypeParam;
  for (int k = 0; k < average_periods; ++k) {
    const T noise = k % 2 == 0 ? T(0.3) : T(-0.3);
    this->offset.step(this->reading(T(0.4) + noise, T(-0.5) - noise, T(0)));
  }
  const ThreePhase<T> i = this->offset.removed_from(this->reading(T(10), T(-10), T(0))).i_abc;
  EXPECT_NEAR(i.a, T(9.6), T(1e-3));
  EXPECT_NEAR(i.b, T(-9.5), T(1e-3));
  EXPECT_EQ(i.c, T(0));
  EXPECT_NEAR(this->offset.largest(), T(0.5), T(1e-3));
}

TYPED_TEST(CurrentOffsetOf, BeyondItsLimitIsSeenAndRemovedUpToIt) {
  using T = TypeParam;
  const Measurement<T> m = this->reading(T(-1.5), T(0), T(0.3));
  this->run(m, average_periods - 1);
  EXPECT_EQ(this->offset.largest(), T(0)) << "the mean does not span its time yet";
  this->run(m, 1);
  EXPECT_NEAR(this->offset.largest(), T(1.5), T(1e-4));
  EXPECT_NEAR(this->offset.removed_from(m).i_abc.a, T(-1.5) + this->limit, T(1e-6));
}

TYPED_TEST(CurrentOffsetOf, IsNotThatOfCurrentsThatFlow) {
  using T = TypeParam;
  this->run(this->reading(T(0.2), T(0), T(0)), average_periods);
  this->run(this->reading(T(100), T(-50), T(-50), switch_states[1]), 1000);
  this->run(this->reading(T(30), T(-20), T(-10)), rest_periods);
  EXPECT_NEAR(this->offset.largest(), T(0.2), T(1e-4)) << "until the gates have been off for 10 ms";
  this->run(this->reading(T(0.3), T(0), T(0)), 10 * average_periods);
  EXPECT_NEAR(this->offset.largest(), T(0.3), T(1e-3));
}

TYPED_TEST(CurrentOffsetOf, ForgetsAWildReading) {
  using T = TypeParam;
  this->run(this->reading(T(0), T(0), T(0)), average_periods);
  this->run(this->reading(T(1e30), T(0), T(-1e30)), 10 * average_periods);
  EXPECT_GT(this->offset.largest(), this->limit);
  this->run(this->reading(T(0), T(0), T(0)), 1200);
  EXPECT_LT(this->offset.largest(), this->limit) << "after 30 ms";
}

TYPED_TEST(CurrentOffsetOf, BeyondItsLimitIsAFaultOfASensorInEachPhaseAndSign) {
  using T = TypeParam;
  FaultSet expected;
  expected.set(Fault::current_sensor);
  for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) {
    for (const T sign : {T(-1), T(1)}) {
      const auto run = [&](T mean) {
        Protection<T> protection{typename Protection<T>::Parameters{.current_offset = this->limit}};
        Measurement<T> m = this->reading(T(0), T(0), T(0));
        m.i_abc.*phase = sign * mean;
        FaultSet faults;
        for (int k = 0; k < average_periods; ++k) faults = protection.step(m);
        return faults;
      };
      EXPECT_FALSE(run(T(0.57)).any());
      EXPECT_EQ(run(T(0.59)), expected);
    }
  }
}

}  // namespace
}  // namespace sextant
