// The sensor of the winding's temperature against what its errors are: statistics, steps of the converter,
// and the answer of first order to a step.
#include "sextant/power_stage/temperature_sensor.hpp"

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "sextant/power_stage/sensor_model.hpp"

namespace sextant {
namespace {

using Parameters = TemperatureSensorParameters;

TEST(TemperatureSensor, IsIdealByDefault) {
  TemperatureSensor sensor{Parameters{}};
  EXPECT_TRUE(sensor.is_ideal());
  EXPECT_EQ(sensor.step(71.234567, 0, 1.0), 71.234567);
  EXPECT_TRUE((SensorModel{SensorParameters{}, PlantFaultParameters{}}.is_ideal()));
}

TEST(TemperatureSensor, ParametersAreChecked) {
  EXPECT_EQ((Parameters{0.01, -2, 0.5, 0.25, 1'000}.validate()), nullptr);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Parameters& p : {Parameters{-1.0}, Parameters{nan}, Parameters{0, nan}, Parameters{0, 0, -1},
                              Parameters{0, 0, nan}, Parameters{0, 0, 0, -1}, Parameters{0, 0, 0, 0, -1}})
    EXPECT_NE(p.validate(), nullptr);
  EXPECT_NE((SensorParameters{.temperature = Parameters{nan}}.validate()), nullptr);
}

TEST(TemperatureSensor, GainAndOffsetAreOfTheReading) {
  TemperatureSensor sensor{{.gain_error = 0.02, .offset = -1.5}};
  EXPECT_NEAR(sensor.step(100, 0, 0.0), 100.5, 1e-12);
  EXPECT_NEAR(sensor.step(-40, 1, 0.0), -42.3, 1e-12);
}

// dx/dt = (T − x)/τ, whatever the times between the readings.
TEST(TemperatureSensor, FollowsAStepWithItsTimeConstant) {
  TemperatureSensor sensor{{.time_constant_ns = 2'000'000'000}};
  EXPECT_EQ(sensor.step(20, 0, 0.0), 20) << "as long at this temperature before";
  std::int64_t t_ns = 0;
  for (const std::int64_t pause_ns :
       std::initializer_list<std::int64_t>{125'000, 700'000'000, 1'300'000'000, 40'000, 3'000'000'000}) {
    t_ns += pause_ns;
    EXPECT_NEAR(sensor.step(120, t_ns, 0.0), 120 - 100 * std::exp(-double(t_ns) / 2e9), 1e-9);
  }
}

TEST(TemperatureSensor, ReadsWholeStepsOfItsConverter) {
  TemperatureSensor sensor{{.step = 0.5}};
  double sum = 0, square = 0;
  constexpr int n = 10'000;
  for (int k = 0; k < n; ++k) {
    const double temperature = -30 + 200 * double(k) / n;
    const double y = sensor.step(temperature, k, 0.0);
    EXPECT_EQ(y, std::round(y / 0.5) * 0.5);
    sum += y - temperature;
    square += (y - temperature) * (y - temperature);
  }
  EXPECT_NEAR(sum / n, 0.0, 1e-3);
  EXPECT_NEAR(std::sqrt(square / n), 0.5 / std::sqrt(12.0), 1e-3) << "of a uniform error";
}

/// Readings of a winding at 80 °C beside currents of zero.
template <class Take>
void read(const SensorParameters& p, int count, Take take) {
  SensorModel sensors{p, {}};
  sensors.begin(0, 0, 0, 50'000);
  for (int k = 0; k < count; ++k) {
    Measurement<double> m;
    m.winding_temperature = 80;
    sensors.step(m, 0, std::int64_t{50'000} * k, 0);
    take(m);
  }
}

// Mean, deviation and neighbours as white noise has them, within five of their own deviations.
TEST(TemperatureSensor, ItsNoiseIsWhiteAndItsOwn) {
  constexpr int n = 20'000;
  SensorParameters p{.temperature = {.offset = 1, .noise = 0.4}, .seed = 7};
  p.current.noise = 1;
  double sum = 0, square = 0, neighbours = 0, with_current = 0, before = 0;
  read(p, n, [&](const Measurement<double>& m) {
    const double error = (*m.winding_temperature - 81) / 0.4;
    sum += error;
    square += error * error;
    neighbours += error * before;
    with_current += error * m.i_abc.a;
    before = error;
  });
  const double five = 5 / std::sqrt(double(n));
  EXPECT_NEAR(sum / n, 0, five);
  EXPECT_NEAR(square / n, 1, five * std::sqrt(2.0));
  EXPECT_NEAR(neighbours / n, 0, five);
  EXPECT_NEAR(with_current / n, 0, five);
}

TEST(TemperatureSensor, ItsNoiseFollowsTheSeedAndLeavesTheOthersAlone) {
  const auto sums = [](const SensorParameters& p) {
    std::pair<double, double> sum{};
    read(p, 50, [&](const Measurement<double>& m) {
      sum.first += *m.winding_temperature;
      sum.second += m.i_abc.a;
    });
    return sum;
  };
  SensorParameters p{.seed = 3};
  p.current.noise = 0.2;
  SensorParameters noisy = p;
  noisy.temperature.noise = 1;
  EXPECT_EQ(sums(noisy), sums(noisy));
  EXPECT_EQ(sums(p).first, 50 * 80.0);
  EXPECT_EQ(sums(noisy).second, sums(p).second);
  SensorParameters other = noisy;
  other.seed = 4;
  EXPECT_NE(sums(other).first, sums(noisy).first);
}

TEST(TemperatureSensor, WithoutAMeasuredTemperatureThereIsNothingToRead) {
  SensorModel sensors{{.temperature = {.offset = 1}}, {}};
  Measurement<double> m;
  sensors.step(m, 0, 0, 0);
  EXPECT_FALSE(m.winding_temperature);
}

}  // namespace
}  // namespace sextant
