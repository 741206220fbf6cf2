#pragma once

#include <array>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// The upper switches that are on, as bits: leg a is bit 0, b bit 1, c bit 2.
[[nodiscard]] constexpr unsigned upper_switches(SwitchState s) noexcept {
  return unsigned(s.a == LegState::high) | unsigned(s.b == LegState::high) << 1U |
         unsigned(s.c == LegState::high) << 2U;
}

/// Stator voltage per DC-link voltage, by `upper_switches`. [-]
template <class T>
inline constexpr std::array<SpaceVector<T>, 8> unit_voltages = [] {
  std::array<SpaceVector<T>, 8> u{};
  for (unsigned n = 0; n < 8; ++n) u[n] = clarke(ThreePhase<T>{T(n & 1U), T(n >> 1U & 1U), T(n >> 2U & 1U)});
  return u;
}();

/// Ideal two-level inverter: stator voltage of a star-connected machine with floating neutral,
///   u_s = 2/3 u_dc (S_a + S_b e^{j2π/3} + S_c e^{-j2π/3}),  S = 1 for a leg that is high.
/// Every leg must be driven (`is_driven`); an `off` leg counts as low. [V]
template <class T>
[[nodiscard]] constexpr SpaceVector<T> stator_voltage(SwitchState s, T u_dc) noexcept {
  return u_dc * unit_voltages<T>[upper_switches(s)];
}

/// Current drawn from the DC link by the driven legs, i_dc = S_a i_a + S_b i_b + S_c i_c. [A]
template <class T>
[[nodiscard]] constexpr T dc_link_current(SwitchState s, ThreePhase<T> i) noexcept {
  return (s.a == LegState::high ? i.a : T(0)) + (s.b == LegState::high ? i.b : T(0)) +
         (s.c == LegState::high ? i.c : T(0));
}

}  // namespace sextant
