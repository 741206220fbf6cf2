#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// What becomes of a pulse of a leg, high or low, that is commanded for less than the minimum pulse.
enum class ShortPulses : std::uint8_t {
  dropped,   ///< it does not act: an edge acts once its leg has been commanded so for the minimum pulse, each
             ///< edge that much later
  stretched  ///< it acts for the minimum pulse: an edge acts at once, and the leg then stays for that long
};

inline constexpr Choice<ShortPulses> short_pulses_choices[]{{"dropped", ShortPulses::dropped},
                                                            {"stretched", ShortPulses::stretched}};

/// The minimum pulse t_min of gate drivers, between the commanded states of the legs and their dead times.
/// Dropped, it is the input filter of a driver,
///   acting(t) = the last state that the leg was commanded for t_min or longer, by t,
/// stretched a lock after each acting edge, at whose end the leg goes on to what is commanded then. A change
/// back within t_min cancels an edge that waits. A pulse is one whatever patterns it lies in. A leg turns off
/// at once, as by the gate-enable line; turning on is an edge.
class MinimumPulse {
 public:
  struct Parameters {
    std::int32_t duration_ns{0};  ///< t_min; 0: none [ns]
    ShortPulses short_pulses{ShortPulses::dropped};

    /// As a drive takes it.
    friend void describe(Description& d, Parameters& p) {
      auto& [shortest_ns, short_ones] = p;
      d.time(
          "minimum_pulse_us", shortest_ns,
          in_us(0, 5e4,
                "shortest time for which the gate drivers keep a leg high or low, before its dead time, as "
                "the drive takes it: the volt-seconds follow from it, and no method commands a shorter "
                "pulse, in one period or across two; from the dead time to below a quarter of the control "
                "period; 0: none",
                Changes::when_ready));
      d.choice(
          "short_pulses", short_ones, short_pulses_choices,
          "what the drivers make of a shorter pulse: none, with every edge minimum_pulse_us late, or one "
          "of minimum_pulse_us",
          Changes::when_ready);
    }
  };

  /// What a leg brings along from one state to the next.
  struct Leg {
    LegState commanded{LegState::off};
    LegState acting{LegState::off};
    std::int32_t wait_ns{0};  ///< until the commanded state acts, or may act [ns]
  };
  using Legs = std::array<Leg, 3>;

  constexpr explicit MinimumPulse(const Parameters& parameters) noexcept SEXTANT_NONBLOCKING
      : parameters_{parameters} {}

  [[nodiscard]] constexpr bool acts() const noexcept SEXTANT_NONBLOCKING {
    return parameters_.duration_ns > 0;
  }

  /// The legs are commanded so now: to be called before each `pass`.
  constexpr void command(SwitchState state, Legs& legs) const noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states{state.a(), state.b(), state.c()};
    for (std::size_t n = 0; n < 3; ++n) {
      Leg& leg = legs[n];
      if (states[n] != leg.commanded) change(states[n], leg);
      if (leg.wait_ns == 0 && leg.acting != leg.commanded) begin(leg);
    }
  }

  /// What acts now.
  [[nodiscard]] static constexpr SwitchState acting(const Legs& legs) noexcept SEXTANT_NONBLOCKING {
    return {legs[0].acting, legs[1].acting, legs[2].acting};
  }

  /// How long that acts, for most_ns at most, without another command. [ns]
  [[nodiscard]] static constexpr std::int32_t holds(const Legs& legs,
                                                    std::int32_t most_ns) noexcept SEXTANT_NONBLOCKING {
    for (const Leg& leg : legs) {
      if (leg.wait_ns > 0) most_ns = std::min(most_ns, leg.wait_ns);
    }
    return most_ns;
  }

  /// Time passes, at most what `holds` tells. [ns]
  constexpr void pass(std::int32_t duration_ns, Legs& legs) const noexcept SEXTANT_NONBLOCKING {
    for (Leg& leg : legs) {
      if (leg.wait_ns == 0) continue;
      leg.wait_ns -= duration_ns;
      // A pulse of just t_min is not dropped; after a stretched one the leg may be commanded otherwise by
      // now.
      if (leg.wait_ns == 0 && parameters_.short_pulses == ShortPulses::dropped) begin(leg);
    }
  }

 private:
  constexpr void change(LegState state, Leg& leg) const noexcept SEXTANT_NONBLOCKING {
    leg.commanded = state;
    if (state == LegState::off) {
      leg.acting = state;
      leg.wait_ns = 0;
    } else if (parameters_.short_pulses == ShortPulses::dropped) {
      leg.wait_ns = state == leg.acting ? 0 : parameters_.duration_ns;
    }
  }

  /// The commanded state begins to act.
  constexpr void begin(Leg& leg) const noexcept SEXTANT_NONBLOCKING {
    leg.acting = leg.commanded;
    leg.wait_ns = parameters_.short_pulses == ShortPulses::stretched ? parameters_.duration_ns : 0;
  }

  Parameters parameters_;
};

}  // namespace sextant
