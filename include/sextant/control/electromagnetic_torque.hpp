#pragma once

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Torque of the machine, T_e = 3/2 p ψ_s × i_s. [N·m]
template <class T>
[[nodiscard]] constexpr T electromagnetic_torque(int pole_pairs, SpaceVector<T> psi_s,
                                                 SpaceVector<T> i_s) noexcept {
  return T(1.5) * T(pole_pairs) * cross(psi_s, i_s);
}

}  // namespace sextant
