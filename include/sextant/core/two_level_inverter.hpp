#pragma once

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Ideal two-level inverter: stator voltage of a star-connected machine with floating neutral,
///   u_s = 2/3 u_dc (S_a + S_b e^{j2π/3} + S_c e^{-j2π/3}),  S = 1 for a leg that is high.
/// Every leg must be driven (`is_driven`); an `off` leg counts as low. [V]
template <class T>
[[nodiscard]] constexpr SpaceVector<T> stator_voltage(SwitchState s, T u_dc) noexcept {
  const auto leg = [](LegState x) { return x == LegState::high ? T(1) : T(0); };
  const SpaceVector<T> unit = clarke(ThreePhase<T>{leg(s.a), leg(s.b), leg(s.c)});
  return u_dc * unit;
}

/// Current drawn from the DC link by the driven legs, i_dc = S_a i_a + S_b i_b + S_c i_c. [A]
template <class T>
[[nodiscard]] constexpr T dc_link_current(SwitchState s, ThreePhase<T> i) noexcept {
  return (s.a == LegState::high ? i.a : T(0)) + (s.b == LegState::high ? i.b : T(0)) +
         (s.c == LegState::high ? i.c : T(0));
}

}  // namespace sextant
