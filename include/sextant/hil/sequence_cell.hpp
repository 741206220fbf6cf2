#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The newest record of one writer for any number of readers, in memory that processes share (a sequence
/// lock). It holds no state of either side, so that each may end at any instruction and be replaced: a record
/// being written then counts as none. The writer never waits; a reader tries a bounded number of times.
///
/// Numbers grow over all writers: a new writer continues from number(). Otherwise a reader that was stopped
/// within a copy could find an equal stamp at the end of another record.
///
/// A record is moved in atomic words: what a reader and a writer touch at once is no data race. A word is
/// stored with release order and loaded with acquire order: a reader of a word of a newer record also reads
/// the stamp set before it.
template <class Record>
class SequenceCell {
  static_assert(std::is_trivially_copyable_v<Record> && sizeof(Record) % sizeof(std::uint64_t) == 0);
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  /// Writer: `number` from 1 and above all before; a reader gets it with the record.
  void store(const Record& record, std::uint64_t number) noexcept SEXTANT_NONBLOCKING {
    const auto words = std::bit_cast<Words>(record);
    stamp_.store(2 * number - 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < count; ++i) words_[i].store(words[i], std::memory_order_release);
    stamp_.store(2 * number, std::memory_order_release);
  }

  /// Writer: the largest number used, also of a record that was not completed; 0 at first.
  [[nodiscard]] std::uint64_t number() const noexcept SEXTANT_NONBLOCKING {
    return (stamp_.load(std::memory_order_relaxed) + 1) / 2;
  }

  /// Reader: the number of the record that was copied; 0, and nothing copied, when there is none or it was
  /// being written at every try.
  [[nodiscard]] std::uint64_t load(Record& record) const noexcept SEXTANT_NONBLOCKING {
    constexpr int tries = 8;
    for (int n = 0; n < tries; ++n) {
      const std::uint64_t before = stamp_.load(std::memory_order_acquire);
      if (before % 2 != 0) continue;
      if (before == 0) return 0;
      Words words;
      for (std::size_t i = 0; i < count; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (stamp_.load(std::memory_order_relaxed) != before) continue;
      record = std::bit_cast<Record>(words);
      return before / 2;
    }
    return 0;
  }

 private:
  static constexpr std::size_t count = sizeof(Record) / sizeof(std::uint64_t);
  using Words = std::array<std::uint64_t, count>;

  std::atomic<std::uint64_t> stamp_{0};  // 2 n: record n is complete; 2 n - 1: it is being written
  std::array<std::atomic<std::uint64_t>, count> words_{};
};

}  // namespace sextant
