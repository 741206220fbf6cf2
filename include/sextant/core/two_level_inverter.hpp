#pragma once

#include <array>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Stator voltage per DC-link voltage, by `SwitchState::upper_switches`. [-]
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
  return u_dc * unit_voltages<T>[s.upper_switches()];
}

/// ∫u_s dt over an applied pattern in which every leg is driven. [V·s]
template <class T>
[[nodiscard]] constexpr SpaceVector<T> volt_seconds(const GatePattern& applied, T u_dc) noexcept {
  SpaceVector<T> sum{};
  for (const GateSegment& segment : applied.segments()) {
    sum += (T(segment.duration_ns) * T(1e-9)) * stator_voltage(segment.state, u_dc);
  }
  return sum;
}

/// Current drawn from the DC link, i_dc = Σ S_x i_x; negative when it flows back. A leg that is off carries
/// its current through a diode: the upper one, into the link, while i_x < 0. [A]
template <class T>
[[nodiscard]] constexpr T dc_link_current(SwitchState s, ThreePhase<T> i) noexcept {
  const auto leg = [](LegState state, T current) {
    const bool to_link = state == LegState::high || (state == LegState::off && current < T(0));
    return to_link ? current : T(0);
  };
  return leg(s.a(), i.a) + leg(s.b(), i.b) + leg(s.c(), i.c);
}

/// Mean of the DC-link current over an applied pattern, from the mean phase currents over the segments in
/// which every leg was driven and over the others; zero for an empty pattern. In a pattern without duration,
/// that of a period without a new measurement, all segments weigh the same. [A]
template <class T>
[[nodiscard]] constexpr T dc_link_current(const GatePattern& applied, ThreePhase<T> i_driven,
                                          ThreePhase<T> i_off) noexcept {
  T duration{};
  for (const GateSegment& segment : applied.segments()) duration += T(segment.duration_ns);
  T mean{};
  for (const GateSegment& segment : applied.segments()) {
    const ThreePhase<T>& i = is_driven(segment.state) ? i_driven : i_off;
    const T part = duration > T(0) ? T(segment.duration_ns) / duration : T(1) / T(applied.segments().size());
    mean += part * dc_link_current(segment.state, i);
  }
  return mean;
}

}  // namespace sextant
