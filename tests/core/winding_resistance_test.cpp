#include "sextant/core/winding_resistance.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class WindingResistanceOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(WindingResistanceOf, Scalars);

// IEC 60034-1: R_2/R_1 = (235 + ϑ_2)/(235 + ϑ_1) of copper.
TYPED_TEST(WindingResistanceOf, OfCopperIsThatOfTheStandard) {
  using T = TypeParam;
  for (const double reference : {0.0, 20.0, 25.0, 95.0}) {
    const WindingResistance<T> copper{T(1 / (235 + reference)), T(reference)};
    for (const double hot : {-40.0, 20.0, 75.0, 115.0, 155.0}) {
      EXPECT_NEAR(copper.ratio(T(hot)), (235 + hot) / (235 + reference), 1e-6) << reference << ", " << hot;
    }
  }
}

TYPED_TEST(WindingResistanceOf, IsConstantByDefaultAndBoundedForASensorThatIsBroken) {
  using T = TypeParam;
  EXPECT_FALSE(WindingResistance<T>{}.varies());
  EXPECT_EQ(WindingResistance<T>{}.ratio(T(150)), T(1));
  const WindingResistance<T> copper{T(0.00393)};
  EXPECT_TRUE(copper.varies());
  EXPECT_EQ(copper.ratio(T(-1e6)), T(0.5));
  EXPECT_EQ(copper.ratio(T(1e6)), T(2));
}

TYPED_TEST(WindingResistanceOf, RefusesWhatIsNoCoefficient) {
  using T = TypeParam;
  EXPECT_EQ((WindingResistance<T>{T(0.004), T(25)}.validate()), nullptr);
  for (const T bad : {T(-0.001), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((WindingResistance<T>{bad, T(20)}.validate()), nullptr);
  }
  EXPECT_NE((WindingResistance<T>{T(0.004), std::numeric_limits<T>::quiet_NaN()}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
