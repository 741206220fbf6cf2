#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sextant {

/// Up to `most` values in sequence, held by value: trivially copyable where T is.
template <class T, std::size_t most>
class BoundedSequence {
 public:
  static constexpr std::size_t capacity = most;

  /// Adds a value at the end. False, and nothing added, when the sequence is full.
  constexpr bool push_back(T value) noexcept {
    if (size_ == most) return false;
    values_[size_++] = value;
    return true;
  }

  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  [[nodiscard]] constexpr std::span<const T> values() const noexcept { return {values_.data(), size_}; }

 private:
  std::array<T, most> values_{};
  std::uint32_t size_{0};
};

}  // namespace sextant
