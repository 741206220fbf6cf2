#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The states of the inverter's legs between two reads, as they act on the plant: with minimum pulse and dead
/// time more than the commanded pattern has segments. Equal neighbours are one segment.
class ActedSegments {
 public:
  /// Each segment of a pattern may begin with an edge of all three legs, which the minimum pulse may take
  /// apart, and one more waits in each leg from before. Each of these begins a dead time and ends one, and
  /// one more ends in each leg that has brought it from before. The first segment begins without an edge.
  static constexpr std::size_t capacity = 2 * (3 * GatePattern::capacity + 3) + 3 + 1;

  /// To be called for no more segments than there is room for.
  constexpr void append(GateSegment segment) noexcept SEXTANT_NONBLOCKING {
    if (segment.duration_ns == 0) return;
    if (count_ > 0 && segments_[count_ - 1].state == segment.state) {
      segments_[count_ - 1].duration_ns += segment.duration_ns;
      return;
    }
    segments_[count_++] = segment;
  }

  [[nodiscard]] constexpr std::span<const GateSegment> segments() const noexcept SEXTANT_NONBLOCKING {
    return {segments_.data(), count_};
  }

 private:
  std::array<GateSegment, capacity> segments_{};
  std::size_t count_{0};
};

}  // namespace sextant
