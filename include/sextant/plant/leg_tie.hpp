#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Where the output of an inverter leg is tied: to the negative rail, to the positive rail (in either case by
/// a switch or by a freewheeling diode), or nowhere, because the leg is off and carries no current.
enum class LegTie : std::uint8_t { low, high, floating };

/// Ties of legs a, b, c.
using LegTies = std::array<LegTie, 3>;

[[nodiscard]] constexpr int floating_legs(const LegTies& ties) noexcept SEXTANT_NONBLOCKING {
  return int(ties[0] == LegTie::floating) + int(ties[1] == LegTie::floating) +
         int(ties[2] == LegTie::floating);
}

[[nodiscard]] constexpr std::array<LegState, 3> leg_states(SwitchState s) noexcept SEXTANT_NONBLOCKING {
  return {s.a(), s.b(), s.c()};
}

/// The tie of a driven leg; an `off` leg is reported as floating.
[[nodiscard]] constexpr LegTie driven_tie(LegState s) noexcept SEXTANT_NONBLOCKING {
  return s == LegState::off ? LegTie::floating : s == LegState::high ? LegTie::high : LegTie::low;
}

/// Unit vectors along the magnetic axes of phases a, b, c. [-]
template <class T>
inline constexpr std::array<SpaceVector<T>, 3> phase_axes{{
    {T(1), T(0)},
    {T(-0.5), std::numbers::sqrt3_v<T> / T(2)},
    {T(-0.5), -std::numbers::sqrt3_v<T> / T(2)},
}};

/// The phase quantities x_a, x_b, x_c of a space vector, as an array.
template <class T>
[[nodiscard]] constexpr std::array<T, 3> phases_of(SpaceVector<T> x) noexcept SEXTANT_NONBLOCKING {
  const ThreePhase<T> abc = inverse_clarke(x);
  return {abc.a, abc.b, abc.c};
}

}  // namespace sextant
