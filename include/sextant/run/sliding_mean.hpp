#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace sextant {

/// Mean of the last n values. The sum is formed anew each time the ring is full, so that rounding errors do
/// not grow with the length of a run.
class SlidingMean {
 public:
  /// n must be above zero.
  explicit SlidingMean(std::size_t n) : ring_(n) {}

  void clear() noexcept {
    next_ = 0;
    full_ = false;
    sum_ = 0;
  }

  void push(double value) noexcept {
    sum_ += value - (full_ ? ring_[next_] : 0.0);
    ring_[next_] = value;
    if (++next_ < ring_.size()) return;
    next_ = 0;
    full_ = true;
    sum_ = std::accumulate(ring_.begin(), ring_.end(), 0.0);
  }

  /// n values have been pushed since `clear`; before, there is no mean.
  [[nodiscard]] bool full() const noexcept { return full_; }
  [[nodiscard]] double value() const noexcept { return sum_ / static_cast<double>(ring_.size()); }

 private:
  std::vector<double> ring_;
  std::size_t next_{0};
  bool full_{false};
  double sum_{0};
};

}  // namespace sextant
