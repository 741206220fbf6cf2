#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/plant/acted_segments.hpp"

namespace sextant {

/// The dead time of the gate drivers: where a leg is commanded from low to high or back, its switch turns off
/// at once and the other one turns on t_d later. In between the leg is off and its diodes carry the current.
/// A command that changes again within t_d begins a new dead time, so that a pulse shorter than t_d turns no
/// switch on. A leg that is commanded on from off waits only for what is left since its last switch turned
/// off. What a dead time lacks at the end of one call acts in the next.
class DeadTime {
 public:
  /// t_d; 0: none. [ns]
  explicit DeadTime(std::int32_t duration_ns) noexcept SEXTANT_NONBLOCKING : duration_ns_{duration_ns} {}

  [[nodiscard]] bool acts() const noexcept SEXTANT_NONBLOCKING { return duration_ns_ > 0; }

  /// What the legs do under commanded segments that follow those of the last call: a pattern, or what a
  /// `PulseFilter` makes of one.
  [[nodiscard]] ActedSegments step(std::span<const GateSegment> commanded) noexcept SEXTANT_NONBLOCKING {
    ActedSegments acted;
    for (const GateSegment& segment : commanded) {
      command(segment.state);
      for (std::int32_t left_ns = segment.duration_ns; left_ns > 0;) {
        const GateSegment now = next(left_ns);
        acted.append(now);
        left_ns -= now.duration_ns;
      }
    }
    return acted;
  }

 private:
  struct Leg {
    LegState commanded{LegState::off};
    std::int32_t dead_ns{0};  ///< until the next switch may turn on [ns]
  };

  void command(SwitchState state) noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states{state.a(), state.b(), state.c()};
    for (std::size_t n = 0; n < 3; ++n) {
      Leg& leg = legs_[n];
      if (states[n] == leg.commanded) continue;
      if (leg.commanded != LegState::off) leg.dead_ns = duration_ns_;
      leg.commanded = states[n];
    }
  }

  /// The legs until the first of their dead times ends, for most_ns at most.
  [[nodiscard]] GateSegment next(std::int32_t most_ns) noexcept SEXTANT_NONBLOCKING {
    std::int32_t duration_ns = most_ns;
    for (const Leg& leg : legs_) {
      if (leg.dead_ns > 0) duration_ns = std::min(duration_ns, leg.dead_ns);
    }
    const auto acting = [](const Leg& leg) { return leg.dead_ns > 0 ? LegState::off : leg.commanded; };
    const SwitchState state{acting(legs_[0]), acting(legs_[1]), acting(legs_[2])};
    for (Leg& leg : legs_) leg.dead_ns = std::max(0, leg.dead_ns - duration_ns);
    return {state, duration_ns};
  }

  std::int32_t duration_ns_;
  std::array<Leg, 3> legs_{};
};

}  // namespace sextant
