#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/sequence_cell.hpp"

namespace sextant {

/// The last `capacity` records of one writer, for readers in other processes. The writer overwrites the
/// oldest and keeps no state of readers: a slow reader loses records, which their numbers show, and a reader
/// may end at any time.
template <class Record, std::size_t capacity>
class RecordRing {
  static_assert(std::has_single_bit(capacity));

 public:
  /// Writer: adds a record and returns its number, from 1.
  std::uint64_t push(const Record& record) noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t number = written_.load(std::memory_order_relaxed) + 1;
    cells_[number % capacity].store(record, number);
    written_.store(number, std::memory_order_release);
    return number;
  }

  /// Number of the newest record; 0 while there is none.
  [[nodiscard]] std::uint64_t newest() const noexcept SEXTANT_NONBLOCKING {
    return written_.load(std::memory_order_acquire);
  }

  /// Number of the oldest record that is safe from being overwritten while it is read.
  [[nodiscard]] std::uint64_t oldest() const noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t last = newest();
    return last < capacity ? 1 : last - capacity + 2;
  }

  /// Reader: copies the record with that number; false when it is overwritten or not written.
  [[nodiscard]] bool read(std::uint64_t number, Record& record) const noexcept SEXTANT_NONBLOCKING {
    Record found;
    if (cells_[number % capacity].load(found) != number) return false;
    record = found;
    return true;
  }

 private:
  std::atomic<std::uint64_t> written_{0};
  std::array<SequenceCell<Record>, capacity> cells_{};
};

}  // namespace sextant
