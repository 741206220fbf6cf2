#pragma once

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Cubic Hermite interpolation between both ends of a step. The derivatives are by the fraction s of the
/// step, from 0 to 1: h dx/dt.
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.6.
template <class State>
struct HermitePath {
  using T = typename State::Scalar;

  State x0, x1;  ///< at s = 0 and 1
  State d0, d1;  ///< dx/ds there

  /// x(s).
  [[nodiscard]] State at(T s) const noexcept SEXTANT_NONBLOCKING {
    const T r = T(1) - s;
    State x;
    for (int i = 0; i < State::RowsAtCompileTime; ++i)
      x[i] =
          (r * x0[i] + s * x1[i]) + (s * r) * ((r * d0[i] - s * d1[i]) - (T(1) - T(2) * s) * (x1[i] - x0[i]));
    return x;
  }
};

}  // namespace sextant
