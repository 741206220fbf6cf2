#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/leg_duties.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Duty cycles of a pattern's legs (`leg_duties`) and its longest state.
struct PatternShares {
  ThreePhase<float> duty{};  ///< [1]
  SwitchState longest{};     ///< the first of several
};

[[nodiscard]] constexpr PatternShares shares_of(const GatePattern& pattern) noexcept {
  PatternShares shares{.duty = leg_duties<float>(pattern), .longest = pattern.last_state()};
  std::int64_t longest_ns = 0;
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
  }
  return shares;
}

}  // namespace sextant
