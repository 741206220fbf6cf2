#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/switch_state.hpp"

namespace sextant {

/// One constant switching state and how long it lasts.
struct GateSegment {
  SwitchState state{};
  std::int32_t duration_ns{};  ///< [ns]
  friend constexpr bool operator==(GateSegment, GateSegment) noexcept = default;
};

/// Up to eight constant switching states in sequence: direct torque control needs one, a symmetric
/// space-vector pattern seven, a late pattern one more. A controller's pattern fills the control period; an
/// applied pattern fills the time between two measurements. An empty pattern means gates off. A segment
/// without duration is kept only while it is the only one: the state in force where no time has passed.
class GatePattern {
 public:
  static constexpr std::size_t capacity = 8;

  constexpr GatePattern() noexcept = default;

  /// One state for the whole period, the same as an empty pattern to which it is appended.
  constexpr GatePattern(SwitchState state, std::int32_t period_ns) noexcept
      : duration_ns_{period_ns}, count_{1}, driven_{sextant::is_driven(state)} {
    segments_[0] = {state, period_ns};
  }

  /// Adds a segment at the end, in the place of one without duration; one without duration is not added to
  /// others. False, and nothing added, when the pattern is full.
  constexpr bool append(GateSegment segment) noexcept {
    if (count_ == 1 && segments_[0].duration_ns == 0) count_ = 0;
    if (segment.duration_ns == 0 && count_ > 0) return true;
    if (count_ == capacity) return false;
    driven_ = sextant::is_driven(segment.state) && (driven_ || count_ == 0);
    duration_ns_ += segment.duration_ns;
    segments_[count_++] = segment;
    return true;
  }

  [[nodiscard]] constexpr std::span<const GateSegment> segments() const noexcept {
    return {segments_.data(), count_};
  }

  /// The state in force at the end of the period, from which the next one commutates.
  [[nodiscard]] constexpr SwitchState last_state() const noexcept {
    return count_ == 0 ? gates_off : segments_[count_ - 1U].state;
  }

  /// True when every leg is driven in every segment, so that the stator voltage follows from the pattern.
  [[nodiscard]] constexpr bool is_driven() const noexcept { return driven_; }

  /// Of all segments. [ns]
  [[nodiscard]] constexpr std::int64_t duration_ns() const noexcept { return duration_ns_; }

  friend constexpr bool operator==(const GatePattern&, const GatePattern&) noexcept = default;

 private:
  std::array<GateSegment, capacity> segments_{};
  std::int64_t duration_ns_{0};
  std::uint8_t count_{0};
  bool driven_{false};
};

}  // namespace sextant
