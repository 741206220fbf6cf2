#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sextant/control/switching_table.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// A switching state, and the share of a period for which it acts; a zero vector for the rest.
template <class T>
struct NearestVector {
  SwitchState state{};
  T share{1};  ///< in (0, 1]
};

/// The one whose mean stator voltage is nearest to u [V] at the link voltage u_dc [V], of the shares that are
/// whole multiples of `quantum`, in (0, 1], and of the whole period; of the zero vectors the one with the
/// fewest commutations from `present`. Along an active vector V the voltage d V with d = u · V/|V|² is
/// nearest, of the multiples the one nearest to d.
template <class T>
[[nodiscard]] constexpr NearestVector<T> nearest_vector(SpaceVector<T> u, T u_dc, SwitchState present,
                                                        T quantum = T(1)) noexcept {
  NearestVector<T> nearest{nearest_zero_state(present), T(1)};
  T best{};
  for (std::size_t n = 1; n <= 6; ++n) {
    const SpaceVector<T> v = stator_voltage(switch_states[n], u_dc);
    const T square = dot(v, v);
    const T along = dot(u, v);
    if (!(along > T(0))) continue;
    const T wanted = std::min(T(1), along / square);
    const T multiple = std::min(T(1), quantum * std::floor(wanted / quantum + T(0.5)));
    const T share = T(2) * wanted > T(1) + multiple ? T(1) : multiple;
    // |u|² less the square of the distance, halved.
    const T gain = share * (along - T(0.5) * share * square);
    if (gain > best) {
      best = gain;
      nearest = {switch_states[n], share};
    }
  }
  return nearest;
}

}  // namespace sextant
