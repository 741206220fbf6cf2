#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// Mean of the DC-link current from measurement to measurement. Over a gap of several periods the currents
/// before it count while the gates were driven, and the currents after it for the rest: with gates off they
/// decay within a fraction of a millisecond.
template <class T = double>
class DcLinkMean {
 public:
  /// Since the last usable measurement; period_ns: control period [ns]. [A]
  [[nodiscard]] constexpr T at(const Measurement<T>& measurement, std::int32_t period_ns) const noexcept {
    const ThreePhase<T>& before = i_before_;
    const ThreePhase<T>& now = measurement.i_abc;
    const ThreePhase<T> mean{T(0.5) * (before.a + now.a), T(0.5) * (before.b + now.b),
                             T(0.5) * (before.c + now.c)};
    const GatePattern& applied = measurement.applied;
    const bool is_gap = !applied.is_driven() && applied.duration_ns() > period_ns;
    return dc_link_current(applied, is_gap ? before : mean, is_gap ? now : mean);
  }

  /// The currents of a usable measurement. [A]
  constexpr void begin_at(const ThreePhase<T>& i) noexcept { i_before_ = i; }

 private:
  ThreePhase<T> i_before_{};  ///< at the last usable measurement [A]
};

}  // namespace sextant
