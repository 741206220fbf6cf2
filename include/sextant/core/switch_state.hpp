#pragma once

#include <array>
#include <cstdint>

namespace sextant {

/// State of an inverter leg: lower device on, upper device on, or both off; then the freewheeling diodes
/// conduct until the phase current is zero.
enum class LegState : std::uint8_t { low, high, off };

/// The states of the three inverter legs, in one byte.
class SwitchState {
 public:
  /// All legs off.
  constexpr SwitchState() noexcept = default;
  constexpr SwitchState(LegState a, LegState b, LegState c) noexcept
      : bits_{std::uint8_t(bits(a) | bits(b) << 1U | bits(c) << 2U)} {}

  [[nodiscard]] constexpr LegState a() const noexcept { return leg(0); }
  [[nodiscard]] constexpr LegState b() const noexcept { return leg(1); }
  [[nodiscard]] constexpr LegState c() const noexcept { return leg(2); }

  /// The upper switches that are on: leg a is bit 0, b bit 1, c bit 2.
  [[nodiscard]] constexpr unsigned upper_switches() const noexcept { return bits_ & 7U; }
  /// The legs that are off, by the same bits.
  [[nodiscard]] constexpr unsigned legs_off() const noexcept { return unsigned(bits_) >> 3U ^ 7U; }

  /// The state as a number below `code_count`, to index a table by.
  [[nodiscard]] constexpr unsigned code() const noexcept { return bits_; }
  static constexpr unsigned code_count = 64;

  friend constexpr bool operator==(SwitchState, SwitchState) noexcept = default;

 private:
  // Bit 0: the leg's upper switch; bit 3: the leg is driven. Zero is gates off.
  static constexpr unsigned bits(LegState s) noexcept {
    return s == LegState::off ? 0U : s == LegState::high ? 9U : 8U;
  }
  [[nodiscard]] constexpr LegState leg(unsigned n) const noexcept {
    if ((legs_off() >> n & 1U) != 0U) return LegState::off;
    return (upper_switches() >> n & 1U) != 0U ? LegState::high : LegState::low;
  }

  std::uint8_t bits_{0};
};

inline constexpr SwitchState gates_off{};

/// True when all three legs are driven, so that the stator voltage follows from the state alone.
[[nodiscard]] constexpr bool is_driven(SwitchState s) noexcept {
  return s.legs_off() == 0U;
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

/// Number of legs whose state differs between x and y.
[[nodiscard]] constexpr int commutations(SwitchState x, SwitchState y) noexcept {
  const unsigned differ = (x.upper_switches() ^ y.upper_switches()) | (x.legs_off() ^ y.legs_off());
  return int((differ & 1U) + (differ >> 1U & 1U) + (differ >> 2U));
}

}  // namespace sextant
