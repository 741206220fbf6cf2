#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Duty cycles of the three legs: the share of a pattern's time for which each leg's upper switch is on,
///   d_x = Σ_k t_k S_x,k / Σ_k t_k,   S_x,k = 1 where leg x is high in segment k, else 0,
/// in [0, 1]; zero for a pattern without duration. [-]
///
/// They are the compare values of three timers. Counters that are aligned to the centre of the period, with
/// the upper switches on about it, make a symmetric space-vector pattern to a nanosecond; of another pattern
/// they keep the mean voltage and not the order of its states. A leg that is off counts as low: the gates of
/// a pattern that is not `is_driven` must be turned off by another way.
template <class T = double>
[[nodiscard]] constexpr ThreePhase<T> leg_duties(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  if (pattern.duration_ns() <= 0) return {};
  ThreePhase<std::int64_t> high_ns{};
  for (const GateSegment& segment : pattern.segments()) {
    if (segment.state.a() == LegState::high) high_ns.a += segment.duration_ns;
    if (segment.state.b() == LegState::high) high_ns.b += segment.duration_ns;
    if (segment.state.c() == LegState::high) high_ns.c += segment.duration_ns;
  }
  const auto all = T(pattern.duration_ns());
  return {T(high_ns.a) / all, T(high_ns.b) / all, T(high_ns.c) / all};
}

}  // namespace sextant
