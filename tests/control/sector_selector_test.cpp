#include "sextant/control/sector_selector.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240505;

template <class T>
class SectorSelectorOf : public testing::Test {
 protected:
  [[nodiscard]] static SectorSelector<T> make(T start) { return SectorSelector<T>{{start}}; }
  [[nodiscard]] static SpaceVector<T> flux(T degrees) {
    return polar(T(1.1), degrees * std::numbers::pi_v<T> / T(180));
  }
  /// The definition, by angle.
  [[nodiscard]] static int sector_at(T degrees, T start) {
    const T from_start = std::fmod(std::fmod(degrees - start, T(360)) + T(360), T(360));
    return int(from_start / T(60)) + 1;
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SectorSelectorOf, Scalars);

// The paper's example: the flux at 40° is in sector 1, at 130° in sector 3.
TYPED_TEST(SectorSelectorOf, ThePapersExampleHoldsWithSectorsThatStartOnV1) {
  using T = TypeParam;
  auto selector = this->make(T(0));
  EXPECT_EQ(selector.step(this->flux(T(40))), 1);
  EXPECT_EQ(selector.step(this->flux(T(130))), 3);
}

TYPED_TEST(SectorSelectorOf, ThePapersExampleHoldsWithCentredSectorsWhereV1LiesAt30Degrees) {
  using T = TypeParam;
  const T v1 = T(30);
  auto selector = this->make(T(-30));
  EXPECT_EQ(selector.step(this->flux(T(40) - v1)), 1);
  EXPECT_EQ(selector.step(this->flux(T(130) - v1)), 3);
}

TYPED_TEST(SectorSelectorOf, CentredSectorsAreCentredOnTheirVectors) {
  using T = TypeParam;
  for (int n = 1; n <= 6; ++n) {
    auto selector = this->make(T(-30));
    EXPECT_EQ(selector.step(this->flux(T(60 * (n - 1)))), n);
  }
}

TYPED_TEST(SectorSelectorOf, FollowsTheAngleOverFullCirclesInBothDirections) {
  using T = TypeParam;
  for (const T start : {T(-30), T(0), T(17), T(180), T(-180)}) {
    auto selector = this->make(start);
    for (int i = -720; i <= 720; ++i) {
      const T degrees = T(i) + T(0.5);
      ASSERT_EQ(selector.step(this->flux(degrees)), this->sector_at(degrees, start))
          << degrees << "° " << start;
    }
    for (int i = 720; i >= -720; --i) {
      const T degrees = T(i) + T(0.5);
      ASSERT_EQ(selector.step(this->flux(degrees)), this->sector_at(degrees, start))
          << degrees << "° " << start;
    }
  }
}

TYPED_TEST(SectorSelectorOf, FindsTheSectorAfterJumpsOfAnySize) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_real_distribution<T> any_start{T(-180), T(180)};
  std::uniform_real_distribution<T> any_angle{T(-180), T(180)};
  std::uniform_real_distribution<T> any_radius{T(1e-6), T(2)};
  for (int selectors = 0; selectors < 50; ++selectors) {
    const T start = any_start(random);
    auto selector = this->make(start);
    for (int i = 0; i < 500; ++i) {
      const T degrees = any_angle(random);
      const T from_edge = std::abs(std::remainder(degrees - start, T(60)));
      if (from_edge < T(1e-3)) continue;  // the rounding of either side decides there
      const auto psi_s = any_radius(random) * this->flux(degrees);
      ASSERT_EQ(selector.step(psi_s), this->sector_at(degrees, start))
          << degrees << "°, start " << start << "°";
      for (const T distance : selector.thresholds(psi_s)) ASSERT_GT(distance, T(0));
    }
  }
}

TYPED_TEST(SectorSelectorOf, KeepsItsSectorAtZeroFlux) {
  using T = TypeParam;
  for (int n = 1; n <= 6; ++n) {
    auto selector = this->make(T(-30));
    selector.step(this->flux(T(60 * (n - 1))));
    EXPECT_EQ(selector.step({}), n);
  }
}

TYPED_TEST(SectorSelectorOf, ThresholdsAreDistancesFromTheTwoEdges) {
  using T = TypeParam;
  auto selector = this->make(T(-30));
  const auto psi_s = this->flux(T(10));
  selector.step(psi_s);
  const auto distance = selector.thresholds(psi_s);
  const T degree = std::numbers::pi_v<T> / T(180);
  EXPECT_NEAR(distance[0], T(1.1) * std::sin(T(40) * degree), T(1e-6));
  EXPECT_NEAR(distance[1], T(1.1) * std::sin(T(20) * degree), T(1e-6));
}

TYPED_TEST(SectorSelectorOf, CrossingAnEdgeLeadsToTheNeighbourAndBack) {
  using T = TypeParam;
  auto selector = this->make(T(-30));
  for (int n = 1; n <= 6; ++n) {
    EXPECT_EQ(selector.sector(), n);
    selector.on_crossing(1);
    EXPECT_EQ(selector.sector(), n % 6 + 1);
    selector.on_crossing(0);
    EXPECT_EQ(selector.sector(), n);
    selector.on_crossing(1);
  }
  selector.on_crossing(0);
  EXPECT_EQ(selector.sector(), 6);
  selector.reset();
  EXPECT_EQ(selector.sector(), 1);
}

TYPED_TEST(SectorSelectorOf, RefusesAStartThatIsNoAngle) {
  using T = TypeParam;
  using Parameters = typename SectorSelector<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  for (const T bad : {T(181), T(-181), std::numeric_limits<T>::quiet_NaN()}) {
    EXPECT_NE(Parameters{bad}.validate(), nullptr);
  }
}

}  // namespace
}  // namespace sextant
