#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// Time in which phase currents die after the gates were turned off. Between them the diodes of two legs
/// apply about 2/3 u_dc against it. After that time the measured current flows. dt without link voltage.
/// sigma_l_s [H], u_dc [V], i_s [A], dt [s]. [s]
template <class T>
[[nodiscard]] T decay_time(T sigma_l_s, T u_dc, SpaceVector<T> i_s, T dt) noexcept {
  const T volt_seconds = T(1.5) * sigma_l_s * magnitude(i_s);
  return volt_seconds < u_dc * dt ? volt_seconds / u_dc : dt;
}

/// Time of an applied pattern until the first leg is off. [s]
template <class T>
[[nodiscard]] constexpr T driven_time(const GatePattern& applied) noexcept {
  std::int64_t t_ns = 0;
  for (const GateSegment& segment : applied.segments()) {
    if (!is_driven(segment.state)) break;
    t_ns += segment.duration_ns;
  }
  return T(t_ns) * T(1e-9);
}

}  // namespace sextant
