#include "sextant/power_stage/converter.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr bool bipolar = true;
constexpr bool unipolar = false;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Converter, AnIdealOneReadsTheTrueValue) {
  for (const double x : {0.0, -0.1, 1.0 / 3.0, 1e9, -1e-12}) {
    EXPECT_EQ(Converter{}(x, 3.0), x);
    EXPECT_EQ((Converter{ConverterParameters{}, bipolar}(x, 3.0)), x);
  }
  EXPECT_TRUE((Converter{ConverterParameters{}, unipolar}.is_ideal()));
}

TEST(Converter, EachImperfectionMakesItRealByItself) {
  for (const ConverterParameters& p :
       {ConverterParameters{.gain_error = 0.01}, ConverterParameters{.offset = 0.5},
        ConverterParameters{.noise = 0.1}, ConverterParameters{.range = 10}}) {
    EXPECT_FALSE((Converter{p, bipolar}.is_ideal()));
  }
}

TEST(Converter, GainOffsetAndNoiseAddUp) {
  const Converter c{{.gain_error = 0.02, .offset = -0.5, .noise = 0.25}, bipolar};
  EXPECT_DOUBLE_EQ(c(100.0, 2.0), 102.0 - 0.5 + 0.5);
  EXPECT_DOUBLE_EQ(c(-100.0, -1.0), -102.0 - 0.5 - 0.25);
}

TEST(Converter, RoundsToTheStepsOfItsBits) {
  constexpr unsigned seed = 41;
  SCOPED_TRACE(seed);
  std::mt19937 random{seed};
  for (const int bits : {1, 2, 8, 12, 16}) {
    SCOPED_TRACE(bits);
    const Converter c{{.range = 300, .bits = bits}, bipolar};
    const double step = 600.0 / std::pow(2.0, bits);
    std::uniform_real_distribution<double> inside{-300.0, 300.0 - 1.5 * step};
    double square = 0;
    constexpr int count = 20'000;
    for (int n = 0; n < count; ++n) {
      const double x = inside(random);
      const double y = c(x, 0.0);
      EXPECT_LE(std::abs(y - x), 0.5 * step * (1 + 1e-12));
      EXPECT_EQ(y / step, std::round(y / step));
      square += (y - x) * (y - x) / count;
    }
    // The error of a fine quantisation is uniform: its variance is that of step/√12.
    if (bits >= 8) {
      EXPECT_NEAR(std::sqrt(square), step / std::sqrt(12.0), 0.02 * step);
    }
  }
}

TEST(Converter, HasAsManyReadingsAsItsBitsAllow) {
  for (const bool is_bipolar : {bipolar, unipolar}) {
    const Converter c{{.range = 8, .bits = 3}, is_bipolar};
    int readings = 1;
    for (double x = -20; x < 20; x += 0.01) readings += c(x + 0.01, 0.0) != c(x, 0.0) ? 1 : 0;
    EXPECT_EQ(readings, 8);
  }
}

TEST(Converter, SaturatesAtTheEndsOfItsRange) {
  const Converter two_sided{{.range = 300, .bits = 12}, bipolar};
  const double step = 600.0 / 4096;
  EXPECT_EQ(two_sided(1e6, 0.0), 300.0 - step);
  EXPECT_EQ(two_sided(-1e6, 0.0), -300.0);
  const Converter one_sided{{.range = 1000, .bits = 10}, unipolar};
  EXPECT_EQ(one_sided(1e6, 0.0), 1000.0 - 1000.0 / 1024);
  EXPECT_EQ(one_sided(-5.0, 0.0), 0.0);
  const Converter analog{{.range = 300}, bipolar};
  EXPECT_EQ(analog(300.5, 0.0), 300.0);
  EXPECT_EQ(analog(-300.5, 0.0), -300.0);
  EXPECT_EQ(analog(299.123, 0.0), 299.123);
}

TEST(Converter, WhatIsNotANumberStaysSo) {
  EXPECT_TRUE(std::isnan(Converter({.range = 300, .bits = 12}, bipolar)(nan, 0.0)));
  EXPECT_TRUE(std::isnan(Converter({.offset = 1}, bipolar)(nan, 0.0)));
}

TEST(Converter, ParametersAreChecked) {
  EXPECT_EQ((ConverterParameters{.range = 1, .bits = 24}.validate()), nullptr);
  EXPECT_NE((ConverterParameters{.gain_error = -1}.validate()), nullptr);
  EXPECT_NE((ConverterParameters{.offset = nan}.validate()), nullptr);
  EXPECT_NE((ConverterParameters{.noise = -0.1}.validate()), nullptr);
  EXPECT_NE((ConverterParameters{.range = -1}.validate()), nullptr);
  EXPECT_NE((ConverterParameters{.range = 1, .bits = 25}.validate()), nullptr);
  EXPECT_STREQ((ConverterParameters{.bits = 12}.validate()), "a converter with bits needs a range");
}

}  // namespace
}  // namespace sextant
