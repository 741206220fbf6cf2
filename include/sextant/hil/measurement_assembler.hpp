#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// The drive's side of a link: makes one measurement of the records that have come since the last one. The
/// applied patterns are joined in order, so that the estimator sees all that happened however the two
/// sides' periods fall; the currents are the newest.
///
/// A measurement is not plausible, so that the drive trips, when the plant does not vouch for it, when
/// records are missing or do not fit the pattern, when the plant has been started anew, and when nothing has
/// come at `missing_periods` calls in a row: calls, so that a drive that was late itself does not blame the
/// plant. After `measurement_timeout_ns` without anything the plant has timed out.
///
/// Nor is it when the plant does not acknowledge the drive's patterns: when `unacknowledged_periods`
/// measurements in a row carry no newer pattern that it took (the way to it is cut, that back is not), and at
/// once when it took a pattern and turned the gates off against it (its gate driver has locked the drive out,
/// or the gate-enable line is off). Gates that opened because a pattern was late are no refusal: nothing
/// newer was taken then.
class MeasurementAssembler {
 public:
  struct Parameters {
    std::int64_t measurement_timeout_ns{
        10'000'000};         ///< without a record for so long the plant has timed out [ns]
    int missing_periods{4};  ///< so many calls in a row without a record are not plausible [-]
    int unacknowledged_periods{
        50};  ///< so many calls in a row with records, but with no newer pattern taken [-]
  };

  struct Counters {
    std::uint64_t records{};         ///< measurements received [-]
    std::uint64_t missing{};         ///< measurements that never came [-]
    std::uint64_t overfull{};        ///< times the patterns did not fit in one [-]
    std::uint64_t restarts{};        ///< times the plant came back as a new one [-]
    std::uint64_t timeouts{};        ///< times it timed out [-]
    std::uint64_t late{};            ///< times nothing came for `missing_periods` [-]
    std::uint64_t unacknowledged{};  ///< times no newer pattern was taken for `unacknowledged_periods` [-]
    std::uint64_t refused{};         ///< patterns against which the plant opened its gates [-]
  };

  explicit MeasurementAssembler(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// The drive has written the command with that number, the first or the next. `driven`: it drives a leg.
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

  /// Everything since the last call, as a measurement at t_ns [ns] of the drive's clock.
  [[nodiscard]] Measurement<double> take(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    if (came_ || !started_) heard_ns_ = t_ns;
    started_ = true;
    const bool timed_out = generation_ == 0 || t_ns - heard_ns_ > parameters_.measurement_timeout_ns;
    if (timed_out && !timed_out_) ++counters_.timeouts;
    timed_out_ = timed_out;
    count_missing();
    count_unacknowledged();
    // Where nothing is new nothing has been applied yet: no time, in the state that is still in force.
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
  /// True while the plant is there and does not take what the drive writes.
  [[nodiscard]] bool unacknowledged() const noexcept SEXTANT_NONBLOCKING {
    return unacknowledged_ >= parameters_.unacknowledged_periods;
  }

 private:
  static constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();

  /// What was applied over a period is the plant's answer to the command that it took at its beginning.
  /// Numbers that are not of this drive, or not newer, are no answer.
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

  /// Appends what was applied; equal neighbours become one. False when there is no room.
  [[nodiscard]] bool join(const GatePattern& next) noexcept SEXTANT_NONBLOCKING {
    GatePattern joined;
    GateSegment open{};
    bool any = false;
    bool fits = true;
    const auto take = [&](GateSegment segment) {
      const std::int64_t both = std::int64_t{open.duration_ns} + segment.duration_ns;
      if (any && open.state == segment.state && both <= std::numeric_limits<std::int32_t>::max()) {
        open.duration_ns = std::int32_t(both);
        return;
      }
      if (any) fits = joined.append(open) && fits;
      open = segment;
      any = true;
    };
    for (const GateSegment& segment : applied_.segments()) take(segment);
    for (const GateSegment& segment : next.segments()) take(segment);
    if (any) fits = joined.append(open) && fits;
    applied_ = joined;
    return fits;
  }

  Parameters parameters_;
  MeasurementRecord newest_{};
  GatePattern applied_{};
  SwitchState last_{};
  Counters counters_{};
  std::int64_t heard_ns_{0};
  std::uint64_t written_{0};          // number of the newest own command; 0: none yet
  std::uint64_t taken_{none};         // of the newest own one that the plant has taken
  std::uint64_t driven_since_{none};  // of the first of the driven ones that the drive writes now
  std::uint32_t generation_{0};
  int missing_{0};
  int unacknowledged_{0};
  bool came_{false};
  bool acknowledged_{false};  // the plant has taken a newer command
  bool started_{false};
  bool usable_{true};
  bool timed_out_{true};
};

/// For a drive with this period [ns]. It waits for a word of its patterns as long as the plant waits for one
/// of them before it gives the drive up.
[[nodiscard]] inline MeasurementAssembler::Parameters assembler_parameters(const HilParameters& p,
                                                                           std::int64_t period_ns) noexcept {
  const auto silence_periods = int((p.pattern_timeout_ns + period_ns - 1) / period_ns);
  return {p.measurement_timeout_ns, p.missing_periods, std::max(p.missing_periods, silence_periods)};
}

}  // namespace sextant
