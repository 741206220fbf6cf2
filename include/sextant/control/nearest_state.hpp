#pragma once

#include <cstddef>

#include "sextant/control/switching_table.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// The switching state whose mean stator voltage is nearest to u [V] at the link voltage u_dc [V] where it
/// acts for a share of the period, in (0, 1], and a zero vector for the rest; of the zero vectors the one
/// with the fewest commutations from `present`.
template <class T>
[[nodiscard]] constexpr SwitchState nearest_state(SpaceVector<T> u, T u_dc, SwitchState present,
                                                  T share = T(1)) noexcept {
  std::size_t nearest = 0;
  T best{};
  for (std::size_t n = 1; n <= 6; ++n) {
    const SpaceVector<T> v = share * stator_voltage(switch_states[n], u_dc);
    const T gain = dot(u, v) - T(0.5) * dot(v, v);
    if (gain > best) {
      best = gain;
      nearest = n;
    }
  }
  return nearest == 0 ? nearest_zero_state(present) : switch_states[nearest];
}

}  // namespace sextant
