#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Goes through the gate segments of a pattern from stop to stop.
class SegmentCursor {
 public:
  explicit SegmentCursor(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING
      : count_{pattern.segments().size()} {
    std::copy(pattern.segments().begin(), pattern.segments().end(), segments_.begin());
  }

  /// What is left, in order; the first segment may be the rest of one.
  [[nodiscard]] std::span<const GateSegment> rest() const noexcept SEXTANT_NONBLOCKING {
    return {segments_.data() + next_, count_ - next_};
  }

  /// True while the first segment of what is left is the rest of one.
  [[nodiscard]] bool resumes() const noexcept SEXTANT_NONBLOCKING { return resumes_; }

  /// The next segments, which last `most_ns` together at most; the last of them may be the first part of one.
  [[nodiscard]] std::span<const GateSegment> take(std::int64_t most_ns) noexcept SEXTANT_NONBLOCKING {
    std::size_t n = 0;
    for (; next_ < count_ && most_ns > 0; ++n) {
      GateSegment& segment = segments_[next_];
      const auto taken_ns = std::int32_t(std::min<std::int64_t>(segment.duration_ns, most_ns));
      taken_[n] = {segment.state, taken_ns};
      most_ns -= taken_ns;
      segment.duration_ns -= taken_ns;
      resumes_ = segment.duration_ns > 0;
      if (!resumes_) ++next_;
    }
    return {taken_.data(), n};
  }

 private:
  std::array<GateSegment, GatePattern::capacity> segments_{};
  std::array<GateSegment, GatePattern::capacity> taken_{};
  std::size_t count_;
  std::size_t next_{0};
  bool resumes_{false};
};

}  // namespace sextant
