#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Share of a pattern's time for which each leg is high, and its longest state. Without time the shares are
/// zero.
struct PatternShares {
  ThreePhase<float> duty{};  ///< [1]
  SwitchState longest{};     ///< the first of several
};

[[nodiscard]] constexpr PatternShares shares_of(const GatePattern& pattern) noexcept {
  PatternShares shares{.longest = pattern.last_state()};
  std::int64_t longest_ns = 0;
  ThreePhase<std::int64_t> high_ns{};
  for (const GateSegment& part : pattern.segments()) {
    // A state may come several times: a symmetric pattern begins and ends with the same one.
    std::int64_t state_ns = 0;
    for (const GateSegment& other : pattern.segments()) {
      if (other.state == part.state) state_ns += other.duration_ns;
    }
    if (state_ns > longest_ns) {
      longest_ns = state_ns;
      shares.longest = part.state;
    }
    if (part.state.a() == LegState::high) high_ns.a += part.duration_ns;
    if (part.state.b() == LegState::high) high_ns.b += part.duration_ns;
    if (part.state.c() == LegState::high) high_ns.c += part.duration_ns;
  }
  if (pattern.duration_ns() <= 0) return shares;
  const auto total = float(pattern.duration_ns());
  shares.duty = {float(high_ns.a) / total, float(high_ns.b) / total, float(high_ns.c) / total};
  return shares;
}

}  // namespace sextant
