#include "sextant/power_stage/normal_noise.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::uint64_t count = 1'000'000;
constexpr std::uint64_t seed = 20'261;

std::vector<double> samples(std::uint64_t of_seed) {
  const NormalNoise noise{of_seed};
  std::vector<double> x;
  x.reserve(count);
  for (std::uint64_t n = 0; n < count; ++n) x.push_back(noise(n));
  return x;
}

// Computed with integers and fractions in Python, from SplitMix64's published constants.
TEST(NormalNoise, IsTheSameOnEveryMachine) {
  EXPECT_NEAR(NormalNoise{1}(0), 0.17911545892299252, 1e-15);
  EXPECT_NEAR(NormalNoise{1}(1), 0.2579500380362163, 1e-15);
  EXPECT_NEAR(NormalNoise{1}(2), -1.8399377636293017, 1e-15);
  EXPECT_NEAR(NormalNoise{7}(123'456'789), 0.801978741714771, 1e-15);
  EXPECT_NEAR(NormalNoise{0}(0), 1.8191957645854222, 1e-15);
}

TEST(NormalNoise, HasTheMomentsOfTheStandardNormalDistribution) {
  SCOPED_TRACE(seed);
  double mean = 0, square = 0, cube = 0, fourth = 0;
  for (const double x : samples(seed)) {
    mean += x / double(count);
    square += x * x / double(count);
    cube += x * x * x / double(count);
    fourth += x * x * x * x / double(count);
  }
  // Within six standard deviations of the estimates; the even moments' own error is below 1e-3.
  const double root = std::sqrt(double(count));
  EXPECT_NEAR(mean, 0.0, 6.0 / root);
  EXPECT_NEAR(square, 1.0, 6.0 * std::sqrt(2.0) / root + 1e-3);
  EXPECT_NEAR(cube, 0.0, 6.0 * std::sqrt(15.0) / root);
  EXPECT_NEAR(fourth, 3.0, 6.0 * std::sqrt(96.0) / root + 5e-3);
}

TEST(NormalNoise, HasTheTailsOfTheNormalDistribution) {
  SCOPED_TRACE(seed);
  const std::vector<double> x = samples(seed);
  for (const double limit : {0.5, 1.0, 2.0, 3.0, 4.0}) {
    SCOPED_TRACE(limit);
    double beyond = 0;
    for (const double sample : x) beyond += std::abs(sample) > limit ? 1.0 : 0.0;
    const double expected = double(count) * std::erfc(limit / std::sqrt(2.0));
    EXPECT_NEAR(beyond, expected, 6.0 * std::sqrt(expected) + 0.05 * expected * (limit > 3.5 ? 1.0 : 0.1));
  }
}

TEST(NormalNoise, IsWhiteAndSoAreItsSeedsToEachOther) {
  SCOPED_TRACE(seed);
  const std::vector<double> x = samples(seed);
  const std::vector<double> next = samples(seed + 1);
  const double limit = 6.0 / std::sqrt(double(count));
  for (std::size_t lag = 1; lag <= 16; ++lag) {
    double correlation = 0;
    for (std::size_t n = lag; n < x.size(); ++n) correlation += x[n] * x[n - lag] / double(count);
    EXPECT_NEAR(correlation, 0.0, limit) << "lag " << lag;
  }
  double correlation = 0;
  for (std::size_t n = 0; n < x.size(); ++n) correlation += x[n] * next[n] / double(count);
  EXPECT_NEAR(correlation, 0.0, limit);
}

}  // namespace
}  // namespace sextant
