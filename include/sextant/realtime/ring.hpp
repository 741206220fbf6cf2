#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/cache_line.hpp"

namespace sextant {

/// Bounded first-in first-out queue from one writer thread to one reader thread. push() never blocks: a full
/// queue drops the new value and counts the drop; queued values stay in order. Memory is allocated and
/// touched in the constructor only.
template <class T>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>, "a value that crosses threads is copied, never constructed");
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  /// Room for at least min_capacity values (rounded up to a power of two). Throws std::invalid_argument for
  /// 0.
  explicit Ring(std::size_t min_capacity)
      : slots_(min_capacity > 0 ? std::bit_ceil(min_capacity)
                                : throw std::invalid_argument("a ring needs room for at least one value")),
        mask_{slots_.size() - 1} {}
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Writer: queues the value; false, and the drop counted, when there is no room.
  bool push(const T& value) noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t write = written_.load(std::memory_order_relaxed);
    if (write - read_seen_by_writer_ > mask_) {
      read_seen_by_writer_ = read_.load(std::memory_order_acquire);
      if (write - read_seen_by_writer_ > mask_) {
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    slots_[write & mask_] = value;
    written_.store(write + 1, std::memory_order_release);
    fetch(slots_[(write + 1) & mask_]);
    return true;
  }

  /// Reader: removes the oldest value; false when there is none.
  bool pop(T& value) noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t read = read_.load(std::memory_order_relaxed);
    if (read == written_seen_by_reader_) {
      written_seen_by_reader_ = written_.load(std::memory_order_acquire);
      if (read == written_seen_by_reader_) return false;
    }
    value = slots_[read & mask_];
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

  /// Values dropped so far; any thread. [-]
  [[nodiscard]] std::uint64_t dropped() const noexcept SEXTANT_NONBLOCKING {
    return dropped_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::size_t capacity() const noexcept SEXTANT_NONBLOCKING { return slots_.size(); }

 private:
  /// Prefetches the slot of the next value. The writer returns to a slot after a whole round, when caches and
  /// translation buffer no longer hold it; the time between two values covers the fetch.
  static void fetch(const T& slot) noexcept SEXTANT_NONBLOCKING {
    const auto* const bytes = reinterpret_cast<const char*>(&slot);
    for (std::size_t at = 0; at < sizeof(T); at += cache_line) __builtin_prefetch(bytes + at, 1);
    __builtin_prefetch(bytes + sizeof(T) - 1, 1);
  }

  std::vector<T> slots_;
  std::size_t mask_;
  // Both counts grow without end. Each side keeps a copy of the other's count and reads the other's cache
  // line only when the ring is full or empty by that copy.
  alignas(cache_line) std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::uint64_t read_seen_by_writer_{0};
  alignas(cache_line) std::atomic<std::uint64_t> read_{0};
  std::uint64_t written_seen_by_reader_{0};
};

}  // namespace sextant
