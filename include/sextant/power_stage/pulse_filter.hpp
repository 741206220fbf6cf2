#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/minimum_pulse.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/acted_segments.hpp"

namespace sextant {

/// The minimum pulse of the simulated gate drivers, which counts the shorter ones. What waits at the end of
/// one call acts in the next.
class PulseFilter {
 public:
  explicit PulseFilter(const MinimumPulse::Parameters& parameters) noexcept SEXTANT_NONBLOCKING
      : minimum_{parameters},
        shortest_ns_{parameters.duration_ns} {}

  [[nodiscard]] bool acts() const noexcept SEXTANT_NONBLOCKING { return minimum_.acts(); }

  /// What passes to the gates of commanded segments that follow those of the last call, GatePattern::capacity
  /// at most.
  [[nodiscard]] ActedSegments step(std::span<const GateSegment> commanded) noexcept SEXTANT_NONBLOCKING {
    ActedSegments passed;
    for (const GateSegment& segment : commanded) {
      count(segment);
      for (std::int32_t left_ns = segment.duration_ns; left_ns > 0;) {
        minimum_.command(segment.state, legs_);
        const std::int32_t part_ns = MinimumPulse::holds(legs_, left_ns);
        passed.append({MinimumPulse::acting(legs_), part_ns});
        minimum_.pass(part_ns, legs_);
        left_ns -= part_ns;
      }
    }
    return passed;
  }

  /// Pulses of a leg so far, high or low, that were commanded for less than the minimum pulse. One that ends
  /// with the leg off does not count.
  [[nodiscard]] std::int64_t short_pulses() const noexcept SEXTANT_NONBLOCKING { return short_pulses_; }

 private:
  void count(const GateSegment& segment) noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states{segment.state.a(), segment.state.b(), segment.state.c()};
    for (std::size_t n = 0; n < 3; ++n) {
      const LegState before = legs_[n].commanded;
      if (states[n] != before) {
        const bool is_pulse = before != LegState::off && states[n] != LegState::off;
        if (is_pulse && since_ns_[n] < shortest_ns_) ++short_pulses_;
        since_ns_[n] = 0;
      }
      since_ns_[n] += segment.duration_ns;
    }
  }

  MinimumPulse minimum_;
  std::int32_t shortest_ns_;
  MinimumPulse::Legs legs_{};
  std::array<std::int64_t, 3> since_ns_{};  ///< the last change of each leg's command [ns]
  std::int64_t short_pulses_{0};
};

}  // namespace sextant
