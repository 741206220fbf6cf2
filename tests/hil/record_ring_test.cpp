#include "sextant/hil/record_ring.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "sextant/hil/sequence_cell.hpp"

namespace sextant {
namespace {

/// A record of which one sees whether it is whole.
struct Record {
  std::array<std::uint64_t, 12> words{};
};

Record record_of(std::uint64_t n) {
  Record r;
  for (std::size_t i = 0; i < r.words.size(); ++i) r.words[i] = n * (i + 1);
  return r;
}

bool is_whole(const Record& r) {
  for (std::size_t i = 0; i < r.words.size(); ++i) {
    if (r.words[i] != r.words[0] * (i + 1)) return false;
  }
  return true;
}

TEST(SequenceCell, HoldsNothingAtFirstThenTheNewest) {
  SequenceCell<Record> cell;
  Record r;
  EXPECT_EQ(cell.load(r), 0U);
  cell.store(record_of(5), 1);
  cell.store(record_of(6), 2);
  EXPECT_EQ(cell.load(r), 2U);
  EXPECT_EQ(r.words[0], 6U);
}

TEST(SequenceCell, AWriterThatDiedWhileWritingLeavesNothingAndIsReplaced) {
  SequenceCell<Record> cell;
  cell.store(record_of(5), 1);
  // The stamp is the first word; an odd one says that record 2 was being written.
  reinterpret_cast<std::atomic<std::uint64_t>*>(&cell)->store(3);
  Record r;
  EXPECT_EQ(cell.load(r), 0U);
  cell.store(record_of(7), cell.number() + 1);
  EXPECT_EQ(cell.load(r), 3U);
  EXPECT_EQ(r.words[0], 7U);
}

TEST(SequenceCell, AWriterThatTakesOverUsesNoNumberTwice) {
  SequenceCell<Record> cell;
  EXPECT_EQ(cell.number(), 0U);
  for (std::uint64_t n = 1; n <= 5; ++n) cell.store(record_of(n), n);
  EXPECT_EQ(cell.number(), 5U);
  reinterpret_cast<std::atomic<std::uint64_t>*>(&cell)->store(11);  // died while it wrote record 6
  EXPECT_EQ(cell.number(), 6U);
}

TEST(SequenceCell, AReaderSeesWholeRecordsInOrderWhileTheyAreWritten) {
  SequenceCell<Record> cell;
  const std::jthread writer{[&](const std::stop_token& stop) {
    for (std::uint64_t n = 1; !stop.stop_requested(); ++n) cell.store(record_of(n), n);
  }};
  std::uint64_t before = 0;
  // On processors that others share reader and writer seldom run at once; then it is fewer.
  constexpr int enough = 11;
  const auto begin = std::chrono::steady_clock::now();
  int got = 0;
  const auto goes_on = [&] {
    const auto waited = std::chrono::steady_clock::now() - begin;
    return got < 20'000 && waited < (got < enough ? std::chrono::minutes{1} : std::chrono::seconds{2});
  };
  while (goes_on()) {
    Record r;
    const std::uint64_t number = cell.load(r);
    if (number == 0 || number == before) {
      std::this_thread::yield();  // the writer does not run, or is in our way
      continue;
    }
    ++got;
    ASSERT_TRUE(is_whole(r));
    ASSERT_EQ(r.words[0], number);
    ASSERT_GE(number, before);
    before = number;
  }
  EXPECT_GE(got, enough);
}

TEST(RecordRing, KeepsTheNewestAndKnowsWhichAreGone) {
  RecordRing<Record, 8> ring;
  Record r;
  EXPECT_EQ(ring.newest(), 0U);
  EXPECT_FALSE(ring.read(1, r));
  for (std::uint64_t n = 1; n <= 20; ++n) EXPECT_EQ(ring.push(record_of(n)), n);
  EXPECT_EQ(ring.newest(), 20U);
  EXPECT_FALSE(ring.read(12, r)) << "overwritten";
  EXPECT_FALSE(ring.read(21, r)) << "not there yet";
  EXPECT_EQ(ring.oldest(), 14U);
  for (std::uint64_t n = ring.oldest(); n <= 20; ++n) {
    ASSERT_TRUE(ring.read(n, r));
    EXPECT_EQ(r.words[0], n);
  }
}

TEST(RecordRing, AReaderInTimeGetsEachRecordOnceAndASlowOneLosesWholeRecords) {
  const auto ring = std::make_unique<RecordRing<Record, 64>>();
  constexpr std::uint64_t last = 200'000;
  const std::jthread writer{[&] {
    for (std::uint64_t n = 1; n <= last; ++n) ring->push(record_of(n));
  }};
  std::uint64_t seen = 0;
  std::uint64_t lost = 0;
  std::uint64_t got = 0;
  while (seen < last) {
    const std::uint64_t newest = ring->newest();
    const std::uint64_t oldest = ring->oldest();  // once: it moves on
    if (seen < newest && oldest > seen + 1) {
      lost += oldest - 1 - seen;
      seen = oldest - 1;
    }
    for (Record r; seen < newest;) {
      ++seen;
      if (!ring->read(seen, r)) {
        ++lost;
        continue;
      }
      ++got;
      ASSERT_TRUE(is_whole(r));
      ASSERT_EQ(r.words[0], seen);
    }
  }
  EXPECT_EQ(got + lost, last);
  EXPECT_GT(got, 0U);
}

}  // namespace
}  // namespace sextant
