#include "sextant/safety/winding_temperature.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class WindingTemperatureOf : public testing::Test {
 protected:
  using Parameters = typename WindingTemperature<T>::Parameters;

  /// A sinusoidal current of this RMS value.
  void run(WindingTemperature<T>& winding, double seconds, double rms) {
    const double peak = std::sqrt(2.0) * rms;
    for (long left = std::lround(seconds / dt); left > 0; --left) {
      const ThreePhase<double> i = inverse_clarke(polar(peak, theta));
      winding.step({T(i.a), T(i.b), T(i.c)}, period_ns);
      theta += 0.01;
    }
  }

  static constexpr std::int32_t period_ns = 250'000;
  static constexpr double dt = period_ns * 1e-9;
  double theta{0};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(WindingTemperatureOf, Scalars);

TYPED_TEST(WindingTemperatureOf, RisesAndFallsExponentiallyToWhatTheSquareOfTheCurrentMakes) {
  using T = TypeParam;
  WindingTemperature<T> winding{
      {.nominal_current = T(12), .nominal_rise = T(80), .time_constant = T(100), .ambient = T(40)}};
  EXPECT_EQ(winding.temperature(), T(40));
  this->run(winding, 100.0, 12.0);
  EXPECT_NEAR(winding.temperature(), 40.0 + 80.0 * (1.0 - std::exp(-1.0)), 0.2);
  this->run(winding, 900.0, 12.0);
  EXPECT_NEAR(winding.temperature(), 120.0, 0.1);
  this->run(winding, 1000.0, 24.0);
  EXPECT_NEAR(winding.temperature(), 360.0, 0.3) << "twice the current, four times the rise";
  this->run(winding, 100.0, 0.0);
  EXPECT_NEAR(winding.temperature(), 40.0 + 320.0 * std::exp(-1.0), 0.5);
}

// Of every second period one is read together with the next.
TYPED_TEST(WindingTemperatureOf, TimeCountsNotReadings) {
  using T = TypeParam;
  WindingTemperature<T> winding{{.nominal_current = T(10), .nominal_rise = T(80), .time_constant = T(10)}};
  const ThreePhase<T> i{T(10), T(-10), T(-10)};  // 10 A RMS
  for (int k = 0; k < 20'000; ++k) {
    winding.step(i, 0);
    winding.step(i, 500'000);
  }
  EXPECT_NEAR(winding.temperature(), 40.0 + 80.0 * (1.0 - std::exp(-1.0)), 0.3);
}

TYPED_TEST(WindingTemperatureOf, OfALargeMachineMovesAlsoInFloat) {
  using T = TypeParam;
  WindingTemperature<T> winding{{.nominal_current = T(100), .time_constant = T(3600)}};
  this->run(winding, 360.0, 100.0);
  EXPECT_NEAR(winding.temperature(), 40.0 + 80.0 * (1.0 - std::exp(-0.1)), 0.05);
}

TYPED_TEST(WindingTemperatureOf, WithoutANominalCurrentIsTheAmbientOne) {
  using T = TypeParam;
  WindingTemperature<T> winding{{}};
  this->run(winding, 100.0, 1000.0);
  EXPECT_EQ(winding.temperature(), T(40));
}

TYPED_TEST(WindingTemperatureOf, AMeasuredOneTakesThePlaceOfTheModelsWhichGoesOnFromThere) {
  using T = TypeParam;
  WindingTemperature<T> winding{
      {.nominal_current = T(12), .nominal_rise = T(80), .time_constant = T(100), .ambient = T(40)}};
  const ThreePhase<T> i{};
  winding.step(i, 25'000, T(90));
  EXPECT_EQ(winding.temperature(), T(90)) << "at once at the beginning";
  for (int k = 0; k < 4000; ++k) winding.step(i, 25'000, T(110));
  EXPECT_EQ(winding.temperature(), T(110));
  this->run(winding, 100.0, 0.0);
  EXPECT_NEAR(winding.temperature(), 40.0 + 70.0 * std::exp(-1.0), 0.2) << "the sensor is gone";
}

TYPED_TEST(WindingTemperatureOf, IsKnownByAModelOrAMeasurement) {
  using T = TypeParam;
  EXPECT_TRUE((WindingTemperature<T>{{.nominal_current = T(12)}}.is_known()));
  WindingTemperature<T> winding{{}};
  winding.step({}, 200'000'000);
  EXPECT_FALSE(winding.is_known());
  winding.step({}, 25'000, T(70));
  EXPECT_TRUE(winding.is_known());
  winding.step({}, 200'000'000);
  EXPECT_EQ(winding.temperature(), T(70)) << "the last one, without a model";
}

TYPED_TEST(WindingTemperatureOf, RefusesWhatIsNoWinding) {
  using T = TypeParam;
  using Winding = typename WindingTemperature<T>::Parameters;
  EXPECT_EQ(Winding{}.validate(), nullptr);
  for (const T bad : {T(0), T(-1), std::numeric_limits<T>::quiet_NaN()}) {
    EXPECT_NE((Winding{.nominal_current = bad}.validate()), nullptr);
    EXPECT_NE((Winding{.nominal_rise = bad}.validate()), nullptr);
    EXPECT_NE((Winding{.time_constant = bad}.validate()), nullptr);
  }
  EXPECT_NE((Winding{.ambient = std::numeric_limits<T>::infinity()}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
