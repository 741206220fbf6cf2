#pragma once

#include <array>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// The switching functions S_a, S_b, S_c by `SwitchState::upper_switches`. [-]
template <class T>
inline constexpr std::array<ThreePhase<T>, 8> switching_functions = [] {
  std::array<ThreePhase<T>, 8> s{};
  for (unsigned n = 0; n < 8; ++n) s[n] = {T(n & 1U), T(n >> 1U & 1U), T(n >> 2U & 1U)};
  return s;
}();

/// Stator voltage per DC-link voltage, by `SwitchState::upper_switches`. [-]
template <class T>
inline constexpr std::array<SpaceVector<T>, 8> unit_voltages = [] {
  std::array<SpaceVector<T>, 8> u{};
  for (unsigned n = 0; n < 8; ++n) u[n] = clarke(switching_functions<T>[n]);
  return u;
}();

/// Ideal two-level inverter: stator voltage of a star-connected machine with floating neutral,
///   u_s = 2/3 u_dc (S_a + S_b e^{j2π/3} + S_c e^{-j2π/3}),  S = 1 for a leg that is high.
/// Every leg must be driven (`is_driven`); an `off` leg counts as low. [V]
template <class T>
[[nodiscard]] constexpr SpaceVector<T> stator_voltage(SwitchState s, T u_dc) noexcept {
  return u_dc * unit_voltages<T>[s.upper_switches()];
}

/// Current drawn from the DC link while every leg is driven, i_dc = Σ S_x i_x. By multiplication: the states
/// change too often for a branch on them to be foreseen. [A]
template <class T>
[[nodiscard]] constexpr T driven_dc_link_current(SwitchState s, ThreePhase<T> i) noexcept {
  const ThreePhase<T>& on = switching_functions<T>[s.upper_switches()];
  return on.a * i.a + on.b * i.b + on.c * i.c;
}

/// Current drawn from the DC link, i_dc = Σ S_x i_x; negative when it flows back. A leg that is off carries
/// its current through a diode: the upper one, into the link, while i_x < 0. [A]
template <class T>
[[nodiscard]] constexpr T dc_link_current(SwitchState s, ThreePhase<T> i) noexcept {
  if (is_driven(s)) return driven_dc_link_current(s, i);
  const auto leg = [](LegState state, T current) {
    if (state == LegState::high) return current;
    return state == LegState::off && current < T(0) ? current : T(0);
  };
  return leg(s.a(), i.a) + leg(s.b(), i.b) + leg(s.c(), i.c);
}

/// Mean of the DC-link current over a pattern that acted, with the phase currents' means over the segments in
/// which every leg was driven and over the others. [A]
template <class T>
[[nodiscard, gnu::noinline]] constexpr T dc_link_current(const GatePattern& acted, ThreePhase<T> i_driven,
                                                         ThreePhase<T> i_open) noexcept {
  if (acted.segments().size() == 1) {
    const SwitchState state = acted.segments().front().state;
    return dc_link_current(state, is_driven(state) ? i_driven : i_open);
  }
  T charge{};
  T time{};
  for (const GateSegment& segment : acted.segments()) {
    const ThreePhase<T> i = is_driven(segment.state) ? i_driven : i_open;
    charge += T(segment.duration_ns) * dc_link_current(segment.state, i);
    time += T(segment.duration_ns);
  }
  return time > T(0) ? charge / time : T(0);
}

}  // namespace sextant
