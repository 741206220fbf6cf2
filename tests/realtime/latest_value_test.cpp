#include "sextant/realtime/latest_value.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(LatestValue, ReaderSeesTheInitialValueAndThenTheNewest) {
  LatestValue<int> cell{7};
  EXPECT_FALSE(cell.update());
  EXPECT_EQ(cell.value(), 7);
  cell.store(8);
  cell.store(9);
  cell.store(10);
  EXPECT_EQ(cell.value(), 7) << "the reader's value changes only when it asks";
  EXPECT_TRUE(cell.update());
  EXPECT_EQ(cell.value(), 10);
  EXPECT_FALSE(cell.update()) << "the same value is new once";
  EXPECT_EQ(cell.latest(), 10);
}

TEST(LatestValue, StoreAndReadInEveryOrder) {
  LatestValue<int> cell{0};
  int newest = 0;
  for (unsigned pattern = 0; pattern < 256; ++pattern) {
    SCOPED_TRACE(pattern);
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((pattern >> bit & 1U) != 0)
        cell.store(++newest);
      else
        ASSERT_EQ(cell.latest(), newest);
    }
  }
}

/// Too large to be copied in one instruction: a torn value has parts that differ.
struct Wide {
  std::array<std::uint64_t, 40> parts{};
};

TEST(LatestValue, ConcurrentReaderNeverSeesATornOrAnOlderValue) {
  constexpr std::uint64_t last = 200'000;
  LatestValue<Wide> cell;
  std::thread writer{[&cell] {
    Wide wide;
    for (std::uint64_t i = 1; i <= last; ++i) {
      wide.parts.fill(i);
      cell.store(wide);
    }
  }};
  std::uint64_t seen = 0;
  std::uint64_t bad = 0;
  while (seen < last) {
    if (!cell.update()) continue;
    const Wide& wide = cell.value();
    bad += wide.parts.front() <= seen ? 1U : 0U;
    for (const std::uint64_t part : wide.parts) bad += part != wide.parts.front() ? 1U : 0U;
    seen = wide.parts.front();
  }
  writer.join();
  EXPECT_EQ(bad, 0U);
}

TEST(LatestValue, WriterAndReaderTouchDifferentCacheLines) {
  EXPECT_GE(alignof(LatestValue<char>), cache_line);
  EXPECT_GE(sizeof(LatestValue<char>), 6 * cache_line);
}

}  // namespace
}  // namespace sextant
