#include "sextant/control/magnetiser.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class MagnetiserOf : public testing::Test {
 protected:
  /// Current reference at a flux and a current; ψ_ref = 1.1 Wb, 13 A hold it, σL_s = 5 mH.
  T step(T psi_s, T current, bool settled = true, T fed_current = T(1000)) {
    return magnetiser.step(psi_s, T(1.1), T(13), current, fed_current, T(0.005), settled);
  }

  Magnetiser<T> magnetiser{{.current_limit = T(40), .hand_over_current = T(30)}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(MagnetiserOf, Scalars);

TYPED_TEST(MagnetiserOf, KeepsTheLimitUntilTheFluxIsThere) {
  using T = TypeParam;
  EXPECT_EQ(this->step(T(0), T(0)), T(40));
  EXPECT_EQ(this->step(T(1.1), T(40)), T(40)) << "0.13 Wb of it are of the current that will go";
  EXPECT_FALSE(this->magnetiser.done());
  EXPECT_EQ(this->step(T(1.23), T(40), false), T(13));
  EXPECT_EQ(this->step(T(1.18), T(29), false), T(13));
  EXPECT_FALSE(this->magnetiser.done()) << "the flux is not to be relied on yet";
  EXPECT_EQ(this->step(T(1.23), T(40)), T(13));
  EXPECT_FALSE(this->magnetiser.done()) << "the current is still above 30 A";
  EXPECT_EQ(this->step(T(1.18), T(30)), T(13));
  EXPECT_TRUE(this->magnetiser.done());
}

TYPED_TEST(MagnetiserOf, KeepsNoMoreThanTheVoltageFeedsButWhatHoldsTheFlux) {
  using T = TypeParam;
  EXPECT_EQ(this->step(T(0.5), T(20), true, T(25)), T(25));
  EXPECT_EQ(this->step(T(0.5), T(20), true, T(5)), T(13));
}

TYPED_TEST(MagnetiserOf, FluxThatSagsWhileTheCurrentFallsWasReached) {
  using T = TypeParam;
  this->step(T(1.23), T(40));
  EXPECT_EQ(this->step(T(1.0), T(20)), T(13));
  EXPECT_TRUE(this->magnetiser.done());
  this->magnetiser.reset();
  EXPECT_FALSE(this->magnetiser.done());
  EXPECT_EQ(this->step(T(1.0), T(0)), T(40));
}

TYPED_TEST(MagnetiserOf, RefusesCurrentsThatAreNone) {
  using T = TypeParam;
  using Parameters = typename Magnetiser<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::infinity(), std::numeric_limits<T>::quiet_NaN()}) {
    EXPECT_NE((Parameters{.current_limit = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.hand_over_current = bad}.validate()), nullptr);
  }
}

}  // namespace
}  // namespace sextant
