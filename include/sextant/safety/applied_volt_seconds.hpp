#pragma once

#include <array>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Phase voltages per DC-link voltage of a star-connected machine with floating neutral,
///   u_a = (2 S_a − S_b − S_c)/3 and cyclically, by `SwitchState::upper_switches`. [-]
template <class T>
inline constexpr std::array<ThreePhase<T>, 8> unit_phase_voltages = [] {
  std::array<ThreePhase<T>, 8> u{};
  for (unsigned n = 0; n < 8; ++n) {
    const int a = int(n & 1U);
    const int b = int(n >> 1U & 1U);
    const int c = int(n >> 2U & 1U);
    u[n] = {T(2 * a - b - c) / T(3), T(2 * b - a - c) / T(3), T(2 * c - a - b) / T(3)};
  }
  return u;
}();

/// Time integral of the phase voltages over an applied pattern in which every leg is driven
/// (`GatePattern::is_driven`), ∫ u_x dt [V·s]. u_dc: link voltage [V]; beyond: what an inverter that is not
/// ideal adds (`InverterModel`) [V·s].
template <class T>
[[nodiscard]] constexpr ThreePhase<T> applied_volt_seconds(const GatePattern& applied, T u_dc,
                                                           const ThreePhase<T>& beyond = {}) noexcept {
  ThreePhase<T> out = beyond;
  for (const GateSegment& segment : applied.segments()) {
    const ThreePhase<T>& u = unit_phase_voltages<T>[segment.state.upper_switches()];
    const T k = u_dc * (T(segment.duration_ns) * T(1e-9));
    out.a += k * u.a;
    out.b += k * u.b;
    out.c += k * u.c;
  }
  return out;
}

}  // namespace sextant
