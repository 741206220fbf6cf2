#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/minimum_pulse.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// What gate drivers make of the commanded states of three legs: first the minimum pulse (`MinimumPulse`),
/// then the dead time t_d, for which both switches of a leg are off where it changes between low and high. A
/// leg that was off turns on without dead time.
class LegTiming {
 public:
  /// What the legs bring along into an interval.
  struct Legs {
    SwitchState commanded{gates_off};       ///< after the minimum pulse
    std::array<std::int32_t, 3> dead_ns{};  ///< what is left of their dead times [ns]
    MinimumPulse::Legs pulses{};            ///< where there is a minimum pulse
  };

  constexpr LegTiming(std::int32_t dead_time_ns, const MinimumPulse::Parameters& minimum_pulse) noexcept
      : dead_time_ns_{dead_time_ns}, minimum_pulse_{minimum_pulse} {}

  /// A state is commanded; returns what the gate drivers make of it now, before the dead times.
  constexpr SwitchState command(SwitchState state, Legs& legs) const noexcept {
    if (minimum_pulse_.acts()) {
      minimum_pulse_.command(state, legs.pulses);
      state = MinimumPulse::acting(legs.pulses);
    }
    begin_dead_times(state, legs);
    return state;
  }

  /// How long that stays so, for most_ns at most. [ns]
  [[nodiscard]] constexpr std::int32_t holds(const Legs& legs, std::int32_t most_ns) const noexcept {
    return minimum_pulse_.acts() ? MinimumPulse::holds(legs.pulses, most_ns) : most_ns;
  }

  /// Time passes, at most what `holds` tells. [ns]
  constexpr void let_pass(std::int32_t duration_ns, Legs& legs) const noexcept {
    for (std::int32_t& dead_ns : legs.dead_ns) dead_ns = std::max<std::int32_t>(0, dead_ns - duration_ns);
    if (minimum_pulse_.acts()) minimum_pulse_.pass(duration_ns, legs.pulses);
  }

  /// The legs go through a pattern.
  constexpr void pass(const GatePattern& pattern, Legs& legs) const noexcept {
    if (pattern.segments().empty()) (void)command(gates_off, legs);
    for (const GateSegment& segment : pattern.segments()) {
      std::int32_t left_ns = segment.duration_ns;
      do {
        (void)command(segment.state, legs);
        const std::int32_t part_ns = holds(legs, left_ns);
        let_pass(part_ns, legs);
        left_ns -= part_ns;
      } while (left_ns > 0);
    }
  }

 private:
  constexpr void begin_dead_times(SwitchState state, Legs& legs) const noexcept {
    const SwitchState before = legs.commanded;
    if (state == before) return;
    const unsigned changes = (before.upper_switches() ^ state.upper_switches()) | state.legs_off();
    for (unsigned n = 0; n < 3; ++n) {
      const bool was_driven = (before.legs_off() >> n & 1U) == 0U;
      if (was_driven && (changes >> n & 1U) != 0U) legs.dead_ns[n] = dead_time_ns_;
    }
    legs.commanded = state;
  }

  std::int32_t dead_time_ns_;  ///< t_d [ns]
  MinimumPulse minimum_pulse_;
};

}  // namespace sextant
