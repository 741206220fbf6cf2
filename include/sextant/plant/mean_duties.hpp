#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/leg_tie.hpp"

namespace sextant {

/// Mean potentials of the legs over gate segments, as shares of the link's voltage, while each current keeps
/// the sign that it has: 1 where a leg is high, 0 where it is low, and where it is off, as in a dead time, 0
/// at i_x > 0 and 1 at i_x < 0, by its diodes. A dead time t_d so takes sign(i_x) t_d of each pair of edges;
/// a leg without current keeps its share, half a share for each time that it is off. [-]
///
/// i_abc: the phase currents [A]. The segments must last.
template <class T>
[[nodiscard]] constexpr ThreePhase<T> mean_duties(std::span<const GateSegment> acted,
                                                  const ThreePhase<T>& i_abc) noexcept SEXTANT_NONBLOCKING {
  const std::array<T, 3> i{i_abc.a, i_abc.b, i_abc.c};
  std::array<T, 3> high_ns{};
  std::int64_t all_ns = 0;
  for (const GateSegment& segment : acted) {
    const std::array<LegState, 3> legs = leg_states(segment.state);
    all_ns += segment.duration_ns;
    for (std::size_t x = 0; x < 3; ++x) {
      if (legs[x] == LegState::high || (legs[x] == LegState::off && i[x] < T(0)))
        high_ns[x] += T(segment.duration_ns);
      else if (legs[x] == LegState::off && i[x] == T(0))
        high_ns[x] += T(0.5) * T(segment.duration_ns);
    }
  }
  const T scale = T(1) / T(all_ns);
  return {scale * high_ns[0], scale * high_ns[1], scale * high_ns[2]};
}

}  // namespace sextant
