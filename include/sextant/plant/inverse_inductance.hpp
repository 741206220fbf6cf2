#pragma once

#include <algorithm>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// A symmetric inverse inductance, as di_s/dpsi_s is where a field has energy: what it is across a direction,
/// and by how much it is larger along that.
template <class T = double>
struct InverseInductance {
  T across{};             ///< [1/H]
  T added_along{};        ///< [1/H]
  SpaceVector<T> axis{};  ///< the direction, of any magnitude; without a meaning where nothing is added

  /// By a change of flux. [A]
  [[nodiscard]] SpaceVector<T> operator()(SpaceVector<T> dpsi) const noexcept SEXTANT_NONBLOCKING {
    const T square = dot(axis, axis);
    const SpaceVector<T> across_part = across * dpsi;
    return square > T(0) ? across_part + (added_along * dot(axis, dpsi) / square) * axis : across_part;
  }
  /// The inverse: the change of flux of a change of current. [Wb]
  [[nodiscard]] SpaceVector<T> flux(SpaceVector<T> di) const noexcept SEXTANT_NONBLOCKING {
    const T square = dot(axis, axis);
    const SpaceVector<T> even = (T(1) / across) * di;
    if (!(square > T(0))) return even;
    return even - (added_along / (across + added_along) * dot(axis, even) / square) * axis;
  }
};

/// Both together, as both axes have it: with the trace of the sum, and, as complex numbers, the difference of
/// its eigenvalues at twice the angle of its axis. added_along of the sum is not below zero.
template <class T>
[[nodiscard]] InverseInductance<T> operator+(const InverseInductance<T>& a,
                                             const InverseInductance<T>& b) noexcept SEXTANT_NONBLOCKING {
  const auto doubled = [](const InverseInductance<T>& x) {
    const T square = dot(x.axis, x.axis);
    if (!(square > T(0))) return SpaceVector<T>{};
    const T scale = T(0.5) * x.added_along / square;
    return SpaceVector<T>{scale * (x.axis.alpha * x.axis.alpha - x.axis.beta * x.axis.beta),
                          scale * T(2) * x.axis.alpha * x.axis.beta};
  };
  const SpaceVector<T> half = doubled(a) + doubled(b);
  const T radius = magnitude(half);
  const T mean = a.across + b.across + T(0.5) * (a.added_along + b.added_along);
  // (cos, sin) of half the angle of (c, s) is along (1 + c, s), and along (s, 1 − c).
  const SpaceVector<T> axis = half.alpha >= T(0) ? SpaceVector<T>{radius + half.alpha, half.beta}
                                                 : SpaceVector<T>{half.beta, radius - half.alpha};
  return {mean - radius, T(2) * radius, axis};
}

}  // namespace sextant
