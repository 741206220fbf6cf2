#pragma once

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A step of h [s] of the classical Runge-Kutta method of order 4 from x, where the slope is k1.
/// slope(s, x, dx): dx/dt at the fraction s of the step, which is 0, 1/2 or 1.
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.1.
template <class Slope, class State>
[[nodiscard]] State runge_kutta_step(const Slope& slope, const State& x, const State& k1,
                                     typename State::Scalar h) noexcept SEXTANT_NONBLOCKING {
  using T = typename State::Scalar;
  constexpr T half = T(0.5);
  State k2, k3, k4;
  slope(half, x + (half * h) * k1, k2);
  slope(half, x + (half * h) * k2, k3);
  slope(T(1), x + h * k3, k4);
  return x + (h / T(6)) * (k1 + T(2) * (k2 + k3) + k4);
}

}  // namespace sextant
