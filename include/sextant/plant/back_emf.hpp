#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// A machine seen from its terminals,
///   u_s = R_s i_s + L' di_s/dt + e,   1/L' = (1/l) (I + q qᵀ)
/// with an inverse transient inductance that may be larger along one axis, as saturation makes it along the
/// flux. Where a leg floats, the stator voltage keeps its current at zero, and l does not matter.
template <class T = double>
struct BackEmf {
  SpaceVector<T> e{};     ///< [V]
  SpaceVector<T> drop{};  ///< R_s i_s; without a meaning where q is zero [V]
  SpaceVector<T> q{};     ///< direction of that axis; its square is the share by which 1/L' is larger [-]

  constexpr BackEmf() noexcept = default;
  /// Of a machine whose transient inductance is the same in each direction.
  constexpr explicit(false) BackEmf(SpaceVector<T> emf) noexcept SEXTANT_NONBLOCKING : e{emf} {}
  constexpr BackEmf(SpaceVector<T> emf, SpaceVector<T> resistive_drop,
                    SpaceVector<T> axis) noexcept SEXTANT_NONBLOCKING : e{emf},
                                                                        drop{resistive_drop},
                                                                        q{axis} {}

  [[nodiscard]] constexpr bool has_axis() const noexcept SEXTANT_NONBLOCKING {
    return q.alpha != T(0) || q.beta != T(0);
  }
};

}  // namespace sextant
