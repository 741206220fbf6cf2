#include "sextant/control/nearest_state.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class NearestStateOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(NearestStateOf, Scalars);

// Every direction and length against a search over all eight states in another metric.
TYPED_TEST(NearestStateOf, HasTheShortestDistance) {
  using T = TypeParam;
  const T u_dc = T(530);
  for (int length = 0; length <= 60; ++length) {
    for (int degrees = 0; degrees < 360; ++degrees) {
      const SpaceVector<T> u = polar(T(10 * length) + T(0.37), T(degrees) * T(0.0174532925));
      const auto distance = [&](SwitchState s) { return magnitude(u - stator_voltage(s, u_dc)); };
      T shortest = distance(switch_states[0]);
      for (const SwitchState s : switch_states) shortest = std::min(shortest, distance(s));
      EXPECT_NEAR(distance(nearest_state(u, u_dc, gates_off)), shortest, T(1e-3)) << length << " " << degrees;
    }
  }
}

TYPED_TEST(NearestStateOf, OfTheZeroVectorsTheOneWithTheFewestCommutations) {
  using T = TypeParam;
  for (const SwitchState present : switch_states) {
    const SwitchState zero = nearest_state(SpaceVector<T>{}, T(530), present);
    EXPECT_LE(commutations(present, zero), 1);
    EXPECT_TRUE(zero == switch_states[0] || zero == switch_states[7]);
  }
}

// Against a search in another metric, of vectors that act for a part of the period.
TYPED_TEST(NearestStateOf, OfAShareOfThePeriodHasTheShortestDistance) {
  using T = TypeParam;
  const T u_dc = T(530);
  for (const T share : {T(0.05), T(0.34), T(0.8)}) {
    for (int length = 0; length <= 20; ++length) {
      for (int degrees = 0; degrees < 360; degrees += 7) {
        const SpaceVector<T> u = polar(T(20 * length) + T(0.37), T(degrees) * T(0.0174532925));
        const auto distance = [&](SwitchState s) { return magnitude(u - share * stator_voltage(s, u_dc)); };
        T shortest = distance(switch_states[0]);
        for (const SwitchState s : switch_states) shortest = std::min(shortest, distance(s));
        EXPECT_NEAR(distance(nearest_state(u, u_dc, gates_off, share)), shortest, T(1e-3))
            << share << " " << length << " " << degrees;
      }
    }
  }
}

}  // namespace
}  // namespace sextant
