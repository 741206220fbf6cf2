#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "sextant/core/gate_pattern.hpp"

namespace sextant {

/// Segments of up to two patterns in order, to be made one pattern; equal neighbours become one segment.
class SegmentList {
 public:
  constexpr void append(std::span<const GateSegment> segments) noexcept {
    for (const GateSegment& segment : segments) append(segment);
  }

  constexpr void append(GateSegment segment) noexcept {
    if (count_ > 0 && lengthen(list_[count_ - 1], segment)) return;
    list_[count_++] = segment;
  }

  /// Appends them to a pattern. Where it has no room, all segments of a state become one at the place of its
  /// last: the volt-seconds stay, the order does not. False when that has no room either.
  [[nodiscard]] constexpr bool join(GatePattern& pattern) noexcept {
    // A segment without duration leaves its place to the first.
    const std::size_t taken = pattern.duration_ns() == 0 ? 0 : pattern.segments().size();
    if (count_ > GatePattern::capacity - taken) gather();
    bool fits = true;
    for (std::size_t k = 0; k < count_; ++k) fits = pattern.append(list_[k]) && fits;
    return fits;
  }

  /// Of all segments. [ns]
  [[nodiscard]] constexpr std::int64_t duration_ns() const noexcept {
    std::int64_t sum = 0;
    for (std::size_t k = 0; k < count_; ++k) sum += list_[k].duration_ns;
    return sum;
  }

  /// Takes the last of them away, as long as `most_ns` together, and returns them. [ns]
  [[nodiscard]] constexpr SegmentList cut_end(std::int64_t most_ns) noexcept {
    std::int64_t before_ns = std::max<std::int64_t>(0, duration_ns() - most_ns);
    SegmentList end;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      const auto first_ns = std::int32_t(std::min<std::int64_t>(before_ns, list_[k].duration_ns));
      before_ns -= first_ns;
      if (first_ns < list_[k].duration_ns || list_[k].duration_ns == 0) {
        end.append({list_[k].state, list_[k].duration_ns - first_ns});
      }
      if (first_ns > 0) list_[kept++] = {list_[k].state, first_ns};
    }
    count_ = kept;
    return end;
  }

 private:
  /// One segment of each state.
  constexpr void gather() noexcept {
    std::size_t first = list_.size();  // of what is gathered, at the end of the list
    for (std::size_t k = count_; k-- > 0;) {
      const GateSegment segment = list_[k];
      const auto is_added = [&segment](GateSegment& other) { return lengthen(other, segment); };
      if (std::any_of(list_.begin() + std::ptrdiff_t(first), list_.end(), is_added)) continue;
      list_[--first] = segment;
    }
    count_ = 0;
    while (first < list_.size()) list_[count_++] = list_[first++];
  }

  /// False where the states differ or the time is too long for one segment.
  static constexpr bool lengthen(GateSegment& segment, const GateSegment& by) noexcept {
    const std::int64_t both = std::int64_t{segment.duration_ns} + by.duration_ns;
    if (segment.state != by.state || both > std::numeric_limits<std::int32_t>::max()) return false;
    segment.duration_ns = std::int32_t(both);
    return true;
  }

  std::array<GateSegment, 2 * GatePattern::capacity> list_{};
  std::size_t count_{0};
};

}  // namespace sextant
