#pragma once

#include <array>
#include <cstdint>

namespace sextant {

/// What the two devices of an inverter leg are told to do. `off` opens both; the freewheeling diodes then
/// conduct until the phase current is zero.
enum class LegState : std::uint8_t { low, high, off };

/// The states of the three inverter legs. Aligned to a word, so that it is passed in one register.
struct alignas(4) SwitchState {
  LegState a{LegState::off};
  LegState b{LegState::off};
  LegState c{LegState::off};
  friend constexpr bool operator==(SwitchState, SwitchState) noexcept = default;
};

inline constexpr SwitchState gates_off{};

/// True when all three legs are driven, so that the stator voltage follows from the state alone.
[[nodiscard]] constexpr bool is_driven(SwitchState s) noexcept {
  return s.a != LegState::off && s.b != LegState::off && s.c != LegState::off;
}

/// Number of an inverter voltage vector, 0…7; 0 and 7 are the zero vectors.
using VectorNumber = std::uint8_t;

/// The eight states of the two-level inverter by vector number (paper, Table 3: devices 1, 2, 3 are the
/// upper switches of legs a, b, c). Active vector n lies at (n - 1)·60° from phase a.
inline constexpr std::array<SwitchState, 8> switch_states{{
    {LegState::low, LegState::low, LegState::low},     // V0
    {LegState::high, LegState::low, LegState::low},    // V1,   0°
    {LegState::high, LegState::high, LegState::low},   // V2,  60°
    {LegState::low, LegState::high, LegState::low},    // V3, 120°
    {LegState::low, LegState::high, LegState::high},   // V4, 180°
    {LegState::low, LegState::low, LegState::high},    // V5, 240°
    {LegState::high, LegState::low, LegState::high},   // V6, 300°
    {LegState::high, LegState::high, LegState::high},  // V7
}};

/// Number of legs whose state differs between x and y: the commutations of going from one to the other.
[[nodiscard]] constexpr int commutations(SwitchState x, SwitchState y) noexcept {
  return int(x.a != y.a) + int(x.b != y.b) + int(x.c != y.c);
}

}  // namespace sextant
