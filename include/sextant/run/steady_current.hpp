#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Watches whether the fundamental of a current stays what it is, so that it makes sense to divide by it: the
/// window is cut into 8 to 15 equal blocks, whose means of the current, seen from the stator flux, must lie
/// within 10 % of the mean over all of them. The length of a block doubles as the window grows; what is left
/// over at the end is not a block.
class SteadyCurrent {
 public:
  /// A piece of that length, with the mean of the current over it. [A], [s]
  void add(SpaceVector<> current, double seconds) noexcept {
    charge_ += seconds * current;
    seconds_ += seconds;
    if (seconds_ < block_s_) return;
    blocks_[count_++] = (1 / seconds_) * charge_;
    charge_ = {};
    seconds_ = 0;
    if (count_ == blocks_.size()) merge();
  }

  /// True when every block agrees with the mean. In less than one block nothing contradicts. [A]
  [[nodiscard]] bool agrees_with(SpaceVector<> mean) const noexcept {
    constexpr double tolerance = 0.1;
    return std::all_of(blocks_.begin(), blocks_.begin() + std::ptrdiff_t(count_), [mean](SpaceVector<> b) {
      return magnitude(b - mean) <= tolerance * magnitude(mean);
    });
  }

 private:
  void merge() noexcept {
    count_ /= 2;
    for (std::size_t k = 0; k < count_; ++k) blocks_[k] = 0.5 * (blocks_[2 * k] + blocks_[2 * k + 1]);
    block_s_ *= 2;
  }

  static constexpr double first_block_s = 1e-3;

  std::array<SpaceVector<>, 16> blocks_{};  ///< means [A]
  std::size_t count_{0};
  double block_s_{first_block_s};  ///< least length of a block [s]
  SpaceVector<> charge_{};         ///< of the block that is not complete [A·s]
  double seconds_{0};              ///< its length so far [s]
};

}  // namespace sextant
