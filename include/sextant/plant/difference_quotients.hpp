#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// j = ∂(dx/dt)/∂x at x by central differences, as a Newton iteration needs it. derivative(x, dx): dx/dt at
/// x.
template <class Derivative, class State, class Jacobian>
void difference_quotients(const Derivative& derivative, const State& x,
                          Jacobian& j) noexcept SEXTANT_NONBLOCKING {
  using T = typename State::Scalar;
  // The cube root of the rounding error is the best step of a central difference.
  const T share = std::cbrt(std::numeric_limits<T>::epsilon());
  for (int c = 0; c < State::RowsAtCompileTime; ++c) {
    State ahead = x, behind = x, rise, fall;
    const T h = share * std::max(T(1), std::abs(x[c]));
    ahead[c] += h;
    behind[c] -= h;
    derivative(ahead, rise);
    derivative(behind, fall);
    j.col(c) = (rise - fall) / (ahead[c] - behind[c]);
  }
}

}  // namespace sextant
