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
      const NearestVector<T> found = nearest_vector(u, u_dc, gates_off);
      EXPECT_NEAR(distance(found.state), shortest, T(1e-3)) << length << " " << degrees;
      EXPECT_EQ(found.share, T(1));
    }
  }
}

TYPED_TEST(NearestStateOf, OfTheZeroVectorsTheOneWithTheFewestCommutations) {
  using T = TypeParam;
  for (const SwitchState present : switch_states) {
    const SwitchState zero = nearest_vector(SpaceVector<T>{}, T(530), present).state;
    EXPECT_LE(commutations(present, zero), 1);
    EXPECT_TRUE(zero == switch_states[0] || zero == switch_states[7]);
  }
}

// Against a search in another metric, of vectors that act for multiples of a part of the period, up to the
// longest voltage that a vector has.
TYPED_TEST(NearestStateOf, OfMultiplesOfAShareHasTheShortestDistance) {
  using T = TypeParam;
  const T u_dc = T(530);
  for (const T quantum : {T(0.05), T(0.34), T(0.8)}) {
    for (int length = 0; length <= 20; ++length) {
      for (int degrees = 0; degrees < 360; degrees += 7) {
        const SpaceVector<T> u = polar(T(20 * length) + T(0.37), T(degrees) * T(0.0174532925));
        const auto distance = [&](SwitchState s, T share) {
          return magnitude(u - share * stator_voltage(s, u_dc));
        };
        T shortest = magnitude(u);
        for (const SwitchState s : switch_states) {
          for (T share = quantum; share < T(1); share += quantum) {
            shortest = std::min(shortest, distance(s, share));
          }
          shortest = std::min(shortest, distance(s, T(1)));
        }
        const NearestVector<T> found = nearest_vector(u, u_dc, gates_off, quantum);
        EXPECT_NEAR(distance(found.state, found.share), shortest, T(1e-3))
            << quantum << " " << length << " " << degrees;
      }
    }
  }
}

}  // namespace
}  // namespace sextant
