#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/cache_line.hpp"

namespace sextant {

/// The newest value from one writer thread to one reader thread: a triple buffer. Both sides are wait-free:
/// each owns one slot, and one atomic exchange swaps it for the third. The reader gets whole values in the
/// order of writing, and may miss values in between. T is copied byte by byte.
template <class T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>, "a value that crosses threads is copied, never constructed");
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

 public:
  LatestValue() noexcept = default;
  /// The reader gets `initial` until a value is stored.
  explicit LatestValue(const T& initial) noexcept { slots_[reader_slot_].value = initial; }
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer: makes `value` the newest.
  void store(const T& value) noexcept SEXTANT_NONBLOCKING {
    slots_[writer_slot_].value = value;
    const std::uint8_t offered = static_cast<std::uint8_t>(writer_slot_ | fresh);
    writer_slot_ = shared_.exchange(offered, std::memory_order_acq_rel) & slot_mask;
  }

  /// Reader: fetches the newest value; true when it is another one than before.
  bool update() noexcept SEXTANT_NONBLOCKING {
    if ((shared_.load(std::memory_order_relaxed) & fresh) == 0) return false;
    reader_slot_ = shared_.exchange(reader_slot_, std::memory_order_acq_rel) & slot_mask;
    return true;
  }

  /// Reader: the value fetched last; valid until the next update().
  [[nodiscard]] const T& value() const noexcept SEXTANT_NONBLOCKING { return slots_[reader_slot_].value; }

  /// Reader: the newest value.
  [[nodiscard]] const T& latest() noexcept SEXTANT_NONBLOCKING {
    update();
    return value();
  }

 private:
  static constexpr std::uint8_t slot_mask = 0x3;
  static constexpr std::uint8_t fresh = 0x4;

  struct alignas(cache_line) Slot {
    T value{};
  };

  std::array<Slot, 3> slots_{};
  alignas(cache_line) std::uint8_t writer_slot_{0};
  alignas(cache_line) std::atomic<std::uint8_t> shared_{
      1};  // the third slot, and whether its value is unread
  alignas(cache_line) std::uint8_t reader_slot_{2};
};

}  // namespace sextant
