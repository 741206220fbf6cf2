#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/segment_list.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// The drive's side of a link: joins the records received since the last measurement to one. The applied
/// patterns are appended, so that the estimator integrates all of them for any phase between the two
/// sides' periods; the currents are the newest.
///
/// A measurement is not plausible, so that the drive trips:
///   when the plant marks it as not plausible, or has been restarted;
///   when records are missing or their patterns do not fit into one;
///   when `missing_periods` calls in a row find no record (calls, because a drive may be late itself);
///   after `measurement_timeout_ns` without a record: the plant has timed out;
///   when `unacknowledged_periods` measurements in a row acknowledge no newer pattern: the way to the plant
///   is cut, the way back is not; when the plant acknowledges a driven pattern with gates off: its gate
///   driver has locked the drive out, or the gate-enable line is off. Gates off for a late pattern are no
///   refusal, because no newer pattern is acknowledged with them.
class MeasurementAssembler {
 public:
  struct Parameters {
    std::int64_t measurement_timeout_ns{
        10'000'000};         ///< age of the last record at which the plant has timed out [ns]
    int missing_periods{4};  ///< calls in a row without a record until not plausible [-]
    int unacknowledged_periods{
        50};  ///< measurements in a row without an acknowledgement until not plausible [-]
  };

  struct Counters {
    std::uint64_t records{};         ///< measurements received [-]
    std::uint64_t missing{};         ///< measurements not received [-]
    std::uint64_t overfull{};        ///< times the patterns did not fit into one [-]
    std::uint64_t restarts{};        ///< restarts of the plant [-]
    std::uint64_t timeouts{};        ///< times the plant timed out [-]
    std::uint64_t late{};            ///< times `missing_periods` calls found no record [-]
    std::uint64_t unacknowledged{};  ///< times `unacknowledged_periods` was reached [-]
    std::uint64_t refused{};         ///< driven patterns against which the gates were off [-]
  };

  explicit MeasurementAssembler(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// The drive has written the pattern of that number, the first or the next. `driven`: it drives a leg.
  void wrote(std::uint64_t number, bool driven) noexcept SEXTANT_NONBLOCKING {
    if (written_ == 0) taken_ = number - 1;
    written_ = number;
    if (!driven) {
      driven_since_ = none;
    } else if (driven_since_ == none) {
      driven_since_ = number;
    }
  }

  /// The next record of the link, in order.
  void add(const MeasurementRecord& record) noexcept SEXTANT_NONBLOCKING {
    ++counters_.records;
    if (generation_ != record.generation) {
      if (generation_ != 0) note_restart();
      generation_ = record.generation;
    } else if (record.sequence != newest_.sequence + 1) {
      counters_.missing += record.sequence - newest_.sequence - 1;
      usable_ = false;
    }
    GatePattern applied;
    if (!to_pattern(record.applied, applied) || !join(applied)) {
      ++counters_.overfull;
      usable_ = false;
    }
    if (is_refusal(record.pattern_number, applied)) {
      ++counters_.refused;
      usable_ = false;
    }
    usable_ = usable_ && record.plausible != 0;
    newest_ = record;
    came_ = true;
  }

  /// All records since the last call, as a measurement at t_ns [ns] of the drive's clock.
  [[nodiscard]] Measurement<double> take(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    if (came_ || !started_) last_record_ns_ = t_ns;
    started_ = true;
    const bool timed_out = generation_ == 0 || t_ns - last_record_ns_ > parameters_.measurement_timeout_ns;
    if (timed_out && !timed_out_) ++counters_.timeouts;
    timed_out_ = timed_out;
    count_missing();
    count_unacknowledged();
    // Without a new record the applied pattern has no duration and the last state.
    if (came_) last_ = applied_.last_state();
    Measurement<double> m{
        .i_abc = {newest_.i_a, newest_.i_b, newest_.i_c},
        .u_dc = newest_.u_dc,
        .omega_m = newest_.omega_m,
        .applied = came_ ? applied_ : GatePattern{last_, 0},
        .plausible = usable_ && !timed_out && missing_ < parameters_.missing_periods && !unacknowledged()};
    applied_ = {};
    came_ = false;
    acknowledged_ = false;
    usable_ = true;
    return m;
  }

  [[nodiscard]] const MeasurementRecord& newest() const noexcept SEXTANT_NONBLOCKING { return newest_; }
  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }
  /// True while there is no plant, or it has timed out.
  [[nodiscard]] bool timed_out() const noexcept SEXTANT_NONBLOCKING { return timed_out_; }
  /// True while the plant sends measurements and acknowledges no pattern.
  [[nodiscard]] bool unacknowledged() const noexcept SEXTANT_NONBLOCKING {
    return unacknowledged_ >= parameters_.unacknowledged_periods;
  }

 private:
  static constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();

  /// Updates the acknowledgement; true where the plant acknowledges a driven pattern and applied gates off.
  /// Numbers of another drive, or not newer ones, acknowledge nothing.
  [[nodiscard]] bool is_refusal(std::uint64_t taken,
                                const GatePattern& applied) noexcept SEXTANT_NONBLOCKING {
    if (taken <= taken_ || taken > written_) return false;
    taken_ = taken;
    acknowledged_ = true;
    return taken >= driven_since_ && applied.duration_ns() > 0 && all_gates_off(applied);
  }

  void count_unacknowledged() noexcept SEXTANT_NONBLOCKING {
    if (acknowledged_) unacknowledged_ = 0;
    if (acknowledged_ || !came_ || written_ == 0 || unacknowledged()) return;
    if (++unacknowledged_ == parameters_.unacknowledged_periods) ++counters_.unacknowledged;
  }

  void count_missing() noexcept SEXTANT_NONBLOCKING {
    if (came_ || generation_ == 0) {
      missing_ = 0;
      return;
    }
    if (missing_ == parameters_.missing_periods) return;
    if (++missing_ == parameters_.missing_periods) ++counters_.late;
  }

  void note_restart() noexcept SEXTANT_NONBLOCKING {
    ++counters_.restarts;
    usable_ = false;
    applied_ = {};
  }

  /// Appends an applied pattern in order; false where there is no room.
  [[nodiscard]] bool join(const GatePattern& next) noexcept SEXTANT_NONBLOCKING {
    SegmentList all;
    all.append(applied_.segments());
    all.append(next.segments());
    applied_ = {};
    return all.join(applied_);
  }

  Parameters parameters_;
  MeasurementRecord newest_{};
  GatePattern applied_{};
  SwitchState last_{};
  Counters counters_{};
  std::int64_t last_record_ns_{0};
  std::uint64_t written_{0};          // number of the newest pattern written; 0: none
  std::uint64_t taken_{none};         // of the newest acknowledged one
  std::uint64_t driven_since_{none};  // of the first driven one since gates off
  std::uint32_t generation_{0};
  int missing_{0};
  int unacknowledged_{0};
  bool came_{false};
  bool acknowledged_{false};  // since the last measurement
  bool started_{false};
  bool usable_{true};
  bool timed_out_{true};
};

/// For a drive with this period [ns]. An acknowledgement is due within the plant's own `pattern_timeout_ns`.
[[nodiscard]] inline MeasurementAssembler::Parameters assembler_parameters(const HilParameters& p,
                                                                           std::int64_t period_ns) noexcept {
  const auto timeout_periods = int((p.pattern_timeout_ns + period_ns - 1) / period_ns);
  return {p.measurement_timeout_ns, p.missing_periods, std::max(p.missing_periods, timeout_periods)};
}

}  // namespace sextant
