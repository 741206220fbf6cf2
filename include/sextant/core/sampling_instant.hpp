#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/segment_list.hpp"

namespace sextant {

/// Measurements of a power stage whose currents and link voltage are sampled before a control period begins,
/// as in the middle of a carrier period. The applied pattern of such a measurement ends where the period
/// begins; what moved the currents from one sample to the next is that pattern earlier by the lead.
template <class T = double>
class SamplingInstant {
 public:
  /// lead_ns: time from the sample to the beginning of the period; 0: none. [ns]
  constexpr explicit SamplingInstant(std::int32_t lead_ns) noexcept : lead_ns_{lead_ns} {}

  /// The measurement with the pattern between the sample before and its own; valid until the next call.
  [[nodiscard]] constexpr const Measurement<T>& step(const Measurement<T>& m) noexcept {
    if (lead_ns_ == 0) return m;
    move_back(m);
    return sampled_;
  }

  const Measurement<T>& step(Measurement<T>&& m) = delete;  ///< it would not outlive the call

  /// As after power-up.
  constexpr void reset() noexcept { since_ = {}; }

  /// The pattern from the last sample to the beginning of the period; empty without a lead.
  [[nodiscard]] constexpr const GatePattern& since() const noexcept { return since_; }

 private:
  /// The applied pattern, earlier by the lead, becomes that of the sample.
  constexpr void move_back(const Measurement<T>& m) noexcept {
    SegmentList all;
    all.append(since_.segments());
    all.append(m.applied.segments());
    SegmentList end = all.cut_end(lead_ns_);
    sampled_ = m;
    sampled_.applied = GatePattern{m.applied.last_state(), 0};
    since_ = {};
    // Without room the volt-seconds are not known, as with gates off.
    const bool fits = end.join(since_) && all.join(sampled_.applied);
    if (!fits) sampled_.applied = GatePattern{gates_off, std::int32_t(m.applied.duration_ns())};
  }

  std::int32_t lead_ns_;
  GatePattern since_{};
  Measurement<T> sampled_{};
};

}  // namespace sextant
