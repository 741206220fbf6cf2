#pragma once

#include <array>
#include <cstdint>

#include "sextant/core/switch_state.hpp"

namespace sextant {

/// An entry of the switching table: an active vector 1…6, or `zero_vector` for whichever of V0 and V7 is
/// nearer to the present state.
inline constexpr VectorNumber zero_vector = 0;

/// Optimum voltage vector selection by sector, flux demand and torque demand.
/// Source: I. Takahashi, T. Noguchi, "A new quick-response and high-efficiency control strategy of an
/// induction motor", IEEE Trans. Ind. Appl. IA-22 (1986) 820–827, Table I, as the paper uses it (2.2.3,
/// Figures 4 and 6). Sector n is centred on V_n; torque is counted positive in the direction of the
/// vector numbers.
///   [sector − 1][lower flux, raise flux][lower torque, hold torque, raise torque]
inline constexpr std::array<std::array<std::array<VectorNumber, 3>, 2>, 6> optimum_switching_table{{
    {{{5, zero_vector, 3}, {6, zero_vector, 2}}},  // sector 1
    {{{6, zero_vector, 4}, {1, zero_vector, 3}}},  // sector 2
    {{{1, zero_vector, 5}, {2, zero_vector, 4}}},  // sector 3
    {{{2, zero_vector, 6}, {3, zero_vector, 5}}},  // sector 4
    {{{3, zero_vector, 1}, {4, zero_vector, 6}}},  // sector 5
    {{{4, zero_vector, 2}, {5, zero_vector, 1}}},  // sector 6
}};

/// The zero vector that costs the fewest commutations from `present`; V0 where both cost the same.
[[nodiscard]] constexpr SwitchState nearest_zero_state(SwitchState present) noexcept {
  const int to_v0 = commutations(present, switch_states[0]);
  const int to_v7 = commutations(present, switch_states[7]);
  return to_v0 <= to_v7 ? switch_states[0] : switch_states[7];
}

/// Looks up the coming switching state.
/// sector 1…6; raise_flux from the flux comparator; torque_demand −1, 0, +1 from the torque comparator;
/// present: the state in force, from which the zero vector is chosen.
[[nodiscard]] constexpr SwitchState select_state(std::uint8_t sector, bool raise_flux, int torque_demand,
                                                 SwitchState present) noexcept {
  const VectorNumber n =
      optimum_switching_table[unsigned(sector - 1)][raise_flux ? 1 : 0][unsigned(torque_demand + 1)];
  return n == zero_vector ? nearest_zero_state(present) : switch_states[n];
}

}  // namespace sextant
