#include "sextant/core/space_vector.hpp"

#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240501;

template <class T>
class SpaceVectorOf : public testing::Test {
 protected:
  static constexpr T tolerance = T(20) * std::numeric_limits<T>::epsilon();
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SpaceVectorOf, Scalars);

TYPED_TEST(SpaceVectorOf, ClarkeOfABalancedSystemIsItsPeakAtItsAngle) {
  using T = TypeParam;
  constexpr T shift = T(2) * std::numbers::pi_v<T> / T(3);
  for (int degrees = -180; degrees < 180; degrees += 7) {
    const T theta = T(degrees) * std::numbers::pi_v<T> / T(180);
    const ThreePhase<T> x{T(3) * std::cos(theta), T(3) * std::cos(theta - shift),
                          T(3) * std::cos(theta + shift)};
    const SpaceVector<T> v = clarke(x);
    EXPECT_NEAR(magnitude(v), T(3), T(3) * this->tolerance);
    EXPECT_NEAR(cross(polar(T(1), theta), v), T(0), T(3) * this->tolerance);
    EXPECT_GT(dot(polar(T(1), theta), v), T(0));
  }
}

TYPED_TEST(SpaceVectorOf, InverseClarkeUndoesClarkeWithoutZeroSequence) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<T> amplitude{T(-100), T(100)};
  for (int i = 0; i < 1000; ++i) {
    const SpaceVector<T> v{amplitude(random), amplitude(random)};
    const ThreePhase<T> x = inverse_clarke(v);
    EXPECT_NEAR(x.a + x.b + x.c, T(0), T(100) * this->tolerance);
    const SpaceVector<T> back = clarke(x);
    EXPECT_NEAR(back.alpha, v.alpha, T(100) * this->tolerance);
    EXPECT_NEAR(back.beta, v.beta, T(100) * this->tolerance);
  }
}

TYPED_TEST(SpaceVectorOf, ClarkeDropsTheZeroSequence) {
  using T = TypeParam;
  const SpaceVector<T> with = clarke(ThreePhase<T>{T(5), T(2), T(-1)});
  const SpaceVector<T> without = clarke(ThreePhase<T>{T(3), T(0), T(-3)});
  EXPECT_NEAR(with.alpha, without.alpha, T(10) * this->tolerance);
  EXPECT_NEAR(with.beta, without.beta, T(10) * this->tolerance);
}

TYPED_TEST(SpaceVectorOf, ProductsFollowTheAngleBetweenTheVectors) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<T> any_angle{-std::numbers::pi_v<T>, std::numbers::pi_v<T>};
  for (int i = 0; i < 1000; ++i) {
    const T theta_a = any_angle(random);
    const T theta_b = any_angle(random);
    const SpaceVector<T> a = polar(T(2), theta_a);
    const SpaceVector<T> b = polar(T(3), theta_b);
    EXPECT_NEAR(dot(a, b), T(6) * std::cos(theta_b - theta_a), T(6) * this->tolerance);
    EXPECT_NEAR(cross(a, b), T(6) * std::sin(theta_b - theta_a), T(6) * this->tolerance);
    EXPECT_EQ(dot(a, rotate_90(a)), T(0));
    EXPECT_GT(cross(a, rotate_90(a)), T(0));
    EXPECT_NEAR(angle(a), theta_a, T(4) * this->tolerance);
  }
}

TYPED_TEST(SpaceVectorOf, ProductAndQuotientAreThoseOfComplexNumbers) {
  using T = TypeParam;
  const std::complex<double> a{1.5, -2.0};
  const std::complex<double> b{-0.5, 3.0};
  const auto vector = [](std::complex<double> x) { return SpaceVector<T>{T(x.real()), T(x.imag())}; };
  const auto expect_near = [](SpaceVector<T> x, std::complex<double> y) {
    EXPECT_NEAR(double(x.alpha), y.real(), 1e-6);
    EXPECT_NEAR(double(x.beta), y.imag(), 1e-6);
  };
  expect_near(product(vector(a), vector(b)), a * b);
  expect_near(quotient(vector(a), vector(b)), a / b);
}

TYPED_TEST(SpaceVectorOf, AddsSubtractsAndScalesByComponent) {
  using T = TypeParam;
  const SpaceVector<T> a{T(1), T(-2)};
  const SpaceVector<T> b{T(4), T(8)};
  EXPECT_EQ(a + b, (SpaceVector<T>{T(5), T(6)}));
  EXPECT_EQ(b - a, (SpaceVector<T>{T(3), T(10)}));
  EXPECT_EQ(T(3) * a, (SpaceVector<T>{T(3), T(-6)}));
}

}  // namespace
}  // namespace sextant
