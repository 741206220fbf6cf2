#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Goes through gate segments from stop to stop.
class SegmentCursor {
 public:
  /// The segments must outlive this object.
  explicit SegmentCursor(std::span<const GateSegment> segments) noexcept SEXTANT_NONBLOCKING
      : segments_{segments} {}

  /// The segments of which something is left, in order; what has been taken of the first is not left out.
  [[nodiscard]] std::span<const GateSegment> rest() const noexcept SEXTANT_NONBLOCKING {
    return segments_.subspan(next_);
  }
  /// What is left of the first of them; there must be one. [ns]
  [[nodiscard]] std::int32_t first_ns() const noexcept SEXTANT_NONBLOCKING {
    return segments_[next_].duration_ns - taken_ns_;
  }

  /// True while a part of the first segment of what is left has been taken.
  [[nodiscard]] bool resumes() const noexcept SEXTANT_NONBLOCKING { return taken_ns_ > 0; }

  /// The next segments, GatePattern::capacity at most, which last `most_ns` together at most; the last of
  /// them may be the first part of one. Valid until the next call.
  [[nodiscard]] std::span<const GateSegment> take(std::int64_t most_ns) noexcept SEXTANT_NONBLOCKING {
    std::size_t n = 0;
    for (; next_ < segments_.size() && n < taken_.size() && most_ns > 0; ++n) {
      const std::int32_t left_ns = first_ns();
      const auto part_ns = std::int32_t(std::min<std::int64_t>(left_ns, most_ns));
      taken_[n] = {segments_[next_].state, part_ns};
      most_ns -= part_ns;
      if (part_ns < left_ns) {
        taken_ns_ += part_ns;
      } else {
        taken_ns_ = 0;
        ++next_;
      }
    }
    return {taken_.data(), n};
  }

 private:
  std::span<const GateSegment> segments_;
  std::array<GateSegment, GatePattern::capacity> taken_{};
  std::size_t next_{0};
  std::int32_t taken_ns_{0};  ///< of the first segment of the rest [ns]
};

}  // namespace sextant
