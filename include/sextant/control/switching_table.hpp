#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/switch_state.hpp"

namespace sextant {

/// An entry of the switching table: an active vector 1…6, or `zero_vector` for the one of V0 and V7 with
/// fewer commutations from the present state.
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

/// The table by sector 1…6 with switching states in place of vectors; `gates_off` stands for a zero vector.
/// Row 0 and the fourth column are unused.
inline constexpr auto optimum_states = [] {
  std::array<std::array<std::array<SwitchState, 4>, 2>, 7> states{};
  for (std::size_t sector = 0; sector < 6; ++sector) {
    for (std::size_t flux = 0; flux < 2; ++flux) {
      for (std::size_t torque = 0; torque < 3; ++torque) {
        const VectorNumber n = optimum_switching_table[sector][flux][torque];
        if (n != zero_vector) states[sector + 1][flux][torque] = switch_states[n];
      }
    }
  }
  return states;
}();

/// `nearest_zero_state` of every state, by its code.
inline constexpr std::array<SwitchState, SwitchState::code_count> nearest_zero_states = [] {
  std::array<SwitchState, SwitchState::code_count> nearest{};
  constexpr std::array legs{LegState::low, LegState::high, LegState::off};
  for (const LegState a : legs) {
    for (const LegState b : legs) {
      for (const LegState c : legs) {
        const SwitchState present{a, b, c};
        const int to_v0 = commutations(present, switch_states[0]);
        const int to_v7 = commutations(present, switch_states[7]);
        nearest[present.code()] = to_v0 <= to_v7 ? switch_states[0] : switch_states[7];
      }
    }
  }
  return nearest;
}();

/// The zero vector with the fewest commutations from `present`; V0 where both have the same number.
[[nodiscard]] constexpr SwitchState nearest_zero_state(SwitchState present) noexcept {
  return nearest_zero_states[present.code()];
}

/// Selects the coming switching state from the table.
/// sector 1…6; raise_flux from the flux comparator; torque_demand −1, 0, +1 from the torque comparator;
/// present: the state in force, from which the zero vector is chosen.
[[nodiscard]] constexpr SwitchState select_state(std::uint8_t sector, bool raise_flux, int torque_demand,
                                                 SwitchState present) noexcept {
  const SwitchState active = optimum_states[sector][raise_flux ? 1U : 0U][unsigned(torque_demand + 1)];
  return active == gates_off ? nearest_zero_state(present) : active;
}

/// Selects the coming switching state as above; with `flux_priority` the radial vector V_n of sector n takes
/// the place of the zero vector. It raises |ψ_s| at (2/3) u_dc cos 30° or faster. Under zero vectors the flux
/// decays by R_s i_s, and near zero stator frequency, where the torque holds by itself, active vectors are
/// too rare to make up for it. Source: the loss of flux at low speed and tables modified against it are
/// reviewed by G. S. Buja, M. P. Kazmierkowski, "Direct torque control of PWM inverter-fed AC motors - a
/// survey", IEEE Trans. Ind. Electron. 51 (2004) 744–757.
[[nodiscard]] constexpr SwitchState select_state(std::uint8_t sector, bool raise_flux, int torque_demand,
                                                 SwitchState present, bool flux_priority) noexcept {
  if (flux_priority && torque_demand == 0) return switch_states[sector];
  return select_state(sector, raise_flux, torque_demand, present);
}

}  // namespace sextant
