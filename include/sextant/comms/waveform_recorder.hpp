#pragma once

#include <cstdint>

#include "sextant/comms/pattern_shares.hpp"
#include "sextant/comms/waveform_batch.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

/// Gathers the drive's records of consecutive control periods into a WaveformBatch.
class WaveformRecorder {
 public:
  static constexpr std::int64_t longest_ns = 10'000'000;  ///< time of a batch [ns]

  /// `period_ns`: control period [ns].
  explicit WaveformRecorder(std::int32_t period_ns) noexcept : period_ns_{std::uint32_t(period_ns)} {}

  /// Adds a control period that fits.
  void add(const Telemetry<double>& x) noexcept {
    if (is_empty()) batch_ = {.t_ns = x.t_ns, .period_ns = period_ns_};
    const PatternShares shares = shares_of(x.pattern);
    batch_.offset_ns.push_back(std::uint32_t(x.t_ns - batch_.t_ns));
    batch_.torque_requested_nm.push_back(float(x.torque_requested));
    batch_.torque_reference_nm.push_back(float(x.torque_reference));
    batch_.torque_nm.push_back(float(x.torque));
    batch_.flux_alpha_wb.push_back(float(x.psi_s.alpha));
    batch_.flux_beta_wb.push_back(float(x.psi_s.beta));
    batch_.i_a_a.push_back(float(x.i_abc.a));
    batch_.i_b_a.push_back(float(x.i_abc.b));
    batch_.i_c_a.push_back(float(x.i_abc.c));
    batch_.speed_rad_s.push_back(float(x.omega_m));
    batch_.u_dc_v.push_back(float(x.u_dc));
    batch_.i_dc_a.push_back(float(x.i_dc));
    batch_.duty_a.push_back(shares.duty.a);
    batch_.duty_b.push_back(shares.duty.b);
    batch_.duty_c.push_back(shares.duty.c);
    batch_.switch_state.push_back(
        std::uint8_t(shares.longest.upper_switches() | shares.longest.legs_off() << 3U));
    batch_.sector.push_back(x.sector);
    batch_.state.push_back(std::uint8_t(x.state));
  }

  [[nodiscard]] bool is_empty() const noexcept { return batch_.offset_ns.size() == 0; }
  /// False where the batch is complete without this period, by number or by time.
  [[nodiscard]] bool fits(const Telemetry<double>& x) const noexcept {
    return is_empty() || (batch_.offset_ns.size() < decltype(batch_.offset_ns)::capacity &&
                          x.t_ns - batch_.t_ns < longest_ns);
  }
  [[nodiscard]] const WaveformBatch& batch() const noexcept { return batch_; }
  /// Begins the next batch.
  void reset() noexcept {
    if (!is_empty()) batch_ = {};
  }

 private:
  std::uint32_t period_ns_;
  WaveformBatch batch_{};
};

}  // namespace sextant
