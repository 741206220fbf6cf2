#include "sextant/control/tone_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/control/tone_measurement.hpp"

namespace sextant {
namespace {

template <class T>
class ToneSequenceOf : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(ToneSequenceOf, Scalars);

template <class T>
typename ToneSequence<T>::Parameters three_tones() {
  return {.bias = T(6),
          .amplitude = T(4),
          .slope = T(0.5),
          .tones = 3,
          .blocks = 2,
          .longest_cycle = 320,
          .shortest_cycle = 20,
          .settle_periods = 50,
          .hold_periods = 30};
}

/// What a block shows.
struct Block {
  std::int32_t cycle{};
  int periods{};
  double mean{};
  double sine{};
  double cosine{};
};

template <class T>
std::vector<Block> blocks_of(ToneSequence<T>& tones) {
  std::vector<Block> blocks;
  ToneMeasurement<T> phasor;
  double sum = 0;
  int periods = 0;
  for (int k = 0; k < 100'000 && !tones.is_done(); ++k) {
    const T current = tones.step();
    if (!tones.holds()) continue;
    sum += double(current);
    ++periods;
    phasor.add(current, T(3) * tones.phase().alpha, tones.phase());
    if (!tones.ends_level()) continue;
    EXPECT_EQ(tones.index(), int(blocks.size()));
    blocks.push_back({tones.cycle(), periods, sum / periods, phasor.current().alpha, phasor.current().beta});
    EXPECT_NEAR(phasor.voltage().alpha, 0, 1e-5);
    EXPECT_NEAR(phasor.voltage().beta, 3, 1e-5);
    phasor = {};
    sum = 0;
    periods = 0;
  }
  return blocks;
}

TYPED_TEST(ToneSequenceOf, EachBlockHoldsWholeCyclesOfASineAboveTheDirectCurrent) {
  using T = TypeParam;
  ToneSequence<T> tones{three_tones<T>()};
  const std::vector<Block> blocks = blocks_of(tones);
  const std::int32_t cycles[] = {320, 320, 80, 80, 20, 20};
  const int periods[] = {320, 320, 80, 80, 40, 40};
  ASSERT_EQ(blocks.size(), std::size(cycles));
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    EXPECT_EQ(blocks[k].cycle, cycles[k]);
    EXPECT_EQ(blocks[k].periods, periods[k]);
    EXPECT_NEAR(blocks[k].mean, 6, 1e-4);
    EXPECT_NEAR(blocks[k].sine, 4, 1e-4);
    EXPECT_NEAR(blocks[k].cosine, 0, 1e-4);
  }
}

TYPED_TEST(ToneSequenceOf, ChangesByNoMoreThanRampAndSineAndEndsAtZero) {
  using T = TypeParam;
  const auto p = three_tones<T>();
  ToneSequence<T> tones{p};
  const double steepest = std::max(double(p.slope), 4 * 2 * std::numbers::pi / p.shortest_cycle);
  double before = 0;
  double highest = 0;
  int settled = 0;
  for (int k = 0; k < 5000; ++k) {
    const double current = tones.step();
    ASSERT_LE(std::abs(current - before), steepest + 1e-5);
    highest = std::max(highest, current);
    if (current == 6 && !tones.holds() && highest <= 6) ++settled;
    before = current;
  }
  EXPECT_NEAR(highest, 10, 1e-4);
  EXPECT_GE(settled, 50) << "the direct current settles before the first tone";
  EXPECT_TRUE(tones.is_done());
  EXPECT_FALSE(tones.holds());
  EXPECT_EQ(before, 0);
}

TYPED_TEST(ToneSequenceOf, BeginsAnewAfterReset) {
  using T = TypeParam;
  ToneSequence<T> tones{three_tones<T>()};
  std::vector<T> first;
  for (int k = 0; k < 1200; ++k) first.push_back(tones.step());
  tones.reset();
  EXPECT_EQ(tones.index(), 0);
  for (const T current : first) ASSERT_EQ(tones.step(), current);
}

}  // namespace
}  // namespace sextant
