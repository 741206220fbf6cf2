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
/// k4: gets the slope of the last stage, at the end of the step to within h³.
template <class Slope, class State>
[[nodiscard]] State runge_kutta_step(const Slope& slope, const State& x, const State& k1,
                                     typename State::Scalar h, State& k4) noexcept SEXTANT_NONBLOCKING {
  using T = typename State::Scalar;
  constexpr T half = T(0.5);
  State k2, k3;
  slope(half, along(x, half * h, k1), k2);
  slope(half, along(x, half * h, k2), k3);
  slope(T(1), along(x, h, k3), k4);
  State next;
  for (int i = 0; i < State::RowsAtCompileTime; ++i)
    next[i] = x[i] + (h / T(6)) * (k1[i] + T(2) * (k2[i] + k3[i]) + k4[i]);
  return next;
}

/// The same without the last slope.
template <class Slope, class State>
[[nodiscard]] State runge_kutta_step(const Slope& slope, const State& x, const State& k1,
                                     typename State::Scalar h) noexcept SEXTANT_NONBLOCKING {
  State k4;
  return runge_kutta_step(slope, x, k1, h, k4);
}

}  // namespace sextant
