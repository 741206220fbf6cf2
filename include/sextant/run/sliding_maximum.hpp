#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sextant {

/// Largest of the last n values. Keeps the values that a later one has not exceeded, in falling order, so
/// that a value costs constant time on average.
class SlidingMaximum {
 public:
  /// n must be above zero.
  explicit SlidingMaximum(std::size_t n) : ring_(n) {}

  void clear() noexcept { size_ = 0; }

  void push(double value) noexcept {
    while (size_ > 0 && at(size_ - 1).value <= value) --size_;
    if (size_ > 0 && at(0).number + ring_.size() <= pushed_) {
      first_ = place(1);
      --size_;
    }
    at(size_++) = {pushed_++, value};
  }

  /// Without a meaning before the first value.
  [[nodiscard]] double value() const noexcept { return ring_[first_].value; }

 private:
  struct Entry {
    std::uint64_t number{};  // of pushes before it
    double value{};
  };

  [[nodiscard]] std::size_t place(std::size_t k) const noexcept {
    const std::size_t index = first_ + k;
    return index < ring_.size() ? index : index - ring_.size();
  }
  [[nodiscard]] Entry& at(std::size_t k) noexcept { return ring_[place(k)]; }

  std::vector<Entry> ring_;
  std::size_t first_{0};
  std::size_t size_{0};
  std::uint64_t pushed_{0};
};

}  // namespace sextant
