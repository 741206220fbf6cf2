#pragma once

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// x + h k, by element.
template <class State>
[[nodiscard]] State along(const State& x, typename State::Scalar h,
                          const State& k) noexcept SEXTANT_NONBLOCKING {
  State y;
  for (int i = 0; i < State::RowsAtCompileTime; ++i) y[i] = x[i] + h * k[i];
  return y;
}

/// A step of h [s] of the classical Runge-Kutta method of order 4 from x, where the slope is k1.
/// slope(s, x, dx): dx/dt at the fraction s of the step, which is 0, 1/2 or 1.
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.1.
template <class Slope, class State>
[[nodiscard]] State runge_kutta_step(const Slope& slope, const State& x, const State& k1,
                                     typename State::Scalar h) noexcept SEXTANT_NONBLOCKING {
  using T = typename State::Scalar;
  constexpr T half = T(0.5);
  State k2, k3, k4;
  slope(half, along(x, half * h, k1), k2);
  slope(half, along(x, half * h, k2), k3);
  slope(T(1), along(x, h, k3), k4);
  State next;
  for (int i = 0; i < State::RowsAtCompileTime; ++i)
    next[i] = x[i] + (h / T(6)) * (k1[i] + T(2) * (k2[i] + k3[i]) + k4[i]);
  return next;
}

}  // namespace sextant
