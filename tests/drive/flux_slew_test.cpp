#include "sextant/drive/flux_slew.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class FluxSlewOf : public testing::Test {
 protected:
  /// Time from one share to another in periods of 25 µs. [s]
  static T time_between(FluxSlew<T> slew, T from, T to) {
    slew.reset(from);
    int periods = 0;
    while (slew.step(to, held, dt) != to && periods < 100'000) ++periods;
    return T(periods + 1) * dt;
  }
  static constexpr T dt = T(25e-6);
  static constexpr T held = std::numeric_limits<T>::infinity();
  InductionMachineParameters<T> machine{};
  FluxSlew<T> slew{machine};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(FluxSlewOf, Scalars);

TYPED_TEST(FluxSlewOf, TheWholeFluxRisesInTenAndFallsInTwoTransientTimeConstants) {
  using T = TypeParam;
  const T tau = this->machine.sigma_l_s() / this->machine.l_s() * this->machine.tau_r();
  EXPECT_NEAR(tau, T(5.8e-3), T(1e-4));
  EXPECT_NEAR(this->time_between(this->slew, T(0.2), T(1)), T(0.8) * T(10) * tau, T(5e-5));
  EXPECT_NEAR(this->time_between(this->slew, T(1), T(0.2)), T(0.8) * T(2) * tau, T(5e-5));
}

TYPED_TEST(FluxSlewOf, StaysExactlyAtAConstantTarget) {
  using T = TypeParam;
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(this->slew.step(T(1), this->held, this->dt), T(1));
  EXPECT_FALSE(this->slew.is_slewing());
}

TYPED_TEST(FluxSlewOf, ReportsThatItIsOnItsWayAndIsSetAtOnce) {
  using T = TypeParam;
  (void)this->slew.step(T(0.5), this->held, this->dt);
  EXPECT_TRUE(this->slew.is_slewing());
  EXPECT_EQ(this->slew.reset(T(0.5)), T(0.5));
  EXPECT_FALSE(this->slew.is_slewing());
  EXPECT_EQ(this->slew.share(), T(0.5));
  EXPECT_EQ(this->slew.step(T(0.5), this->held, this->dt), T(0.5));
}

TYPED_TEST(FluxSlewOf, FallsAtOnceToWhatTheLinkHoldsAndRisesFromThere) {
  using T = TypeParam;
  EXPECT_EQ(this->slew.step(T(1), T(0.7), this->dt), T(0.7));
  EXPECT_TRUE(this->slew.is_slewing());
  const T rise = this->slew.step(T(1), this->held, this->dt) - T(0.7);
  EXPECT_GT(rise, T(0));
  EXPECT_LT(rise, T(0.01));
}

}  // namespace
}  // namespace sextant
