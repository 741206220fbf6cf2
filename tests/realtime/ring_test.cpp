#include "sextant/realtime/ring.hpp"

#include <array>
#include <thread>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(Ring, FirstInIsFirstOut) {
  Ring<int> ring{4};
  int value = 0;
  EXPECT_FALSE(ring.pop(value));
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ring.push(10 * round + i));
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(ring.pop(value));
      EXPECT_EQ(value, 10 * round + i);
    }
    EXPECT_FALSE(ring.pop(value));
  }
  EXPECT_EQ(ring.dropped(), 0U);
}

TEST(Ring, AFullRingDropsTheNewestAndCountsIt) {
  Ring<int> ring{4};
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  EXPECT_FALSE(ring.push(5));
  EXPECT_EQ(ring.dropped(), 2U);
  int value = -1;
  ASSERT_TRUE(ring.pop(value));
  EXPECT_EQ(value, 0);
  EXPECT_TRUE(ring.push(6));
  for (const int expected : {1, 2, 3, 6}) {
    ASSERT_TRUE(ring.pop(value));
    EXPECT_EQ(value, expected);
  }
}

// The place after the last one is the first: nothing beyond the memory is fetched, which ASan would not see,
// nor is a value touched that waits to be read.
TEST(Ring, ARoundLeavesWhatIsQueuedAlone) {
  struct Large {
    std::array<std::uint64_t, 22> words{};
  };
  Ring<Large> ring{2};
  Large value;
  for (std::uint64_t i = 0; i < 9; i += 2) {
    value.words.fill(i);
    ASSERT_TRUE(ring.push(value));
    value.words.fill(i + 1);
    ASSERT_TRUE(ring.push(value));
    EXPECT_FALSE(ring.push(value)) << "it is full";
    for (const std::uint64_t expected : {i, i + 1}) {
      ASSERT_TRUE(ring.pop(value));
      for (const std::uint64_t word : value.words) EXPECT_EQ(word, expected);
    }
  }
  EXPECT_EQ(ring.dropped(), 5U);
}

TEST(Ring, CapacityIsRoundedUpToAPowerOfTwo) {
  EXPECT_EQ(Ring<int>{1}.capacity(), 1U);
  EXPECT_EQ(Ring<int>{5}.capacity(), 8U);
  EXPECT_THROW(Ring<int>{0}, std::invalid_argument);
}

struct Sample {
  std::uint64_t number{};
  std::array<std::uint64_t, 15> copies{};
};

TEST(Ring, ConcurrentReaderSeesWholeValuesInOrderAndEveryLossIsCounted) {
  constexpr std::uint64_t last = 300'000;
  Ring<Sample> ring{64};
  std::atomic<bool> done{false};
  std::thread writer{[&] {
    Sample sample;
    for (std::uint64_t i = 1; i <= last; ++i) {
      sample.number = i;
      sample.copies.fill(i);
      ring.push(sample);
    }
    done.store(true, std::memory_order_release);
  }};
  std::uint64_t received = 0;
  std::uint64_t bad = 0;
  std::uint64_t previous = 0;
  Sample sample;
  for (bool finished = false; !finished;) {
    finished = done.load(std::memory_order_acquire);
    while (ring.pop(sample)) {
      ++received;
      bad += sample.number <= previous ? 1U : 0U;
      for (const std::uint64_t copy : sample.copies) bad += copy != sample.number ? 1U : 0U;
      previous = sample.number;
    }
  }
  writer.join();
  EXPECT_EQ(bad, 0U);
  EXPECT_EQ(received + ring.dropped(), last);
  EXPECT_GE(received, ring.capacity());
}

}  // namespace
}  // namespace sextant
