#include "sextant/drive/link_voltage_band.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class LinkVoltageBandOf : public testing::Test {
 protected:
  static constexpr double dt = 25e-6;

  static void hold(LinkVoltageBand<T>& band, double volts, double seconds) {
    for (long left = std::lround(seconds / dt); left > 0; --left) band.step(T(volts), T(dt));
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LinkVoltageBandOf, Scalars);

TYPED_TEST(LinkVoltageBandOf, LeavesAShareInALineBetweenItsEnds) {
  using T = TypeParam;
  for (const double u : {200.0, 300.0, 350.0, 420.0, 500.0, 530.0}) {
    LinkVoltageBand<T> low{{T(500), T(300)}};
    this->hold(low, u, 0.02);
    EXPECT_NEAR(low.share(), std::clamp((u - 300) / 200, 0.0, 1.0), 1e-5) << u;
  }
  for (const double u : {530.0, 600.0, 615.0, 640.0, 660.0, 700.0}) {
    LinkVoltageBand<T> high{{T(600), T(660)}};
    this->hold(high, u, 0.02);
    EXPECT_NEAR(high.share(), std::clamp((660 - u) / 60, 0.0, 1.0), 1e-5) << u;
  }
}

TYPED_TEST(LinkVoltageBandOf, IsNoneByDefault) {
  using T = TypeParam;
  LinkVoltageBand<T> none{{}};
  for (const double u : {0.0, 530.0, 1e6}) {
    this->hold(none, u, 0.002);
    EXPECT_EQ(none.share(), T(1));
  }
}

// The mean of a step from 530 to 380 V is 380 + 150 e^(−t/1 ms).
TYPED_TEST(LinkVoltageBandOf, FallsWithTheMeanOverAMillisecond) {
  using T = TypeParam;
  LinkVoltageBand<T> band{{T(500), T(300)}};
  this->hold(band, 530, 0.01);
  for (int k = 1; k <= 200; ++k) {
    band.step(T(380), T(this->dt));
    const double mean = 380 + 150 * std::exp(-k * this->dt / 1e-3);
    EXPECT_NEAR(band.share(), std::min(1.0, (mean - 300) / 200), 0.01) << k;
  }
}

TYPED_TEST(LinkVoltageBandOf, ReturnsAtTwoASecond) {
  using T = TypeParam;
  LinkVoltageBand<T> band{{T(500), T(300)}};
  this->hold(band, 320, 0.02);
  for (int k = 1; k <= 5; ++k) {
    this->hold(band, 530, 0.1);
    EXPECT_NEAR(band.share(), std::min(1.0, 0.1 + 0.2 * k), 2e-3) << k;
  }
}

// The amplification of a link that oscillates: a voltage that swings over the whole band at 100 Hz moves the
// share by no more than 2/s · 10 ms, from its lowest value.
TYPED_TEST(LinkVoltageBandOf, AVoltageThatOscillatesMovesItLittle) {
  using T = TypeParam;
  LinkVoltageBand<T> band{{T(500), T(300)}};
  double lowest = 1, highest = 0;
  for (int k = 0; k < 8000; ++k) {
    band.step(T(400 + 100 * std::sin(2 * std::numbers::pi * 100 * k * this->dt)), T(this->dt));
    if (k < 4000) continue;
    lowest = std::min(lowest, double(band.share()));
    highest = std::max(highest, double(band.share()));
  }
  EXPECT_LE(highest - lowest, 0.0201);
  EXPECT_GT(highest - lowest, 0.005);
  EXPECT_LT(highest, 0.15);
}

TYPED_TEST(LinkVoltageBandOf, LeavesOutWhatIsNoNumber) {
  using T = TypeParam;
  LinkVoltageBand<T> band{{T(500), T(300)}};
  band.step(std::numeric_limits<T>::quiet_NaN(), T(this->dt));
  EXPECT_EQ(band.share(), T(1));
  this->hold(band, 400, 0.02);
  band.step(std::numeric_limits<T>::quiet_NaN(), T(this->dt));
  band.step(std::numeric_limits<T>::infinity(), T(this->dt));
  this->hold(band, 400, 0.001);
  EXPECT_NEAR(band.share(), 0.5, 1e-3);
}

}  // namespace
}  // namespace sextant
