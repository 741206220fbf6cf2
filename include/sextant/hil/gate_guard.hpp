#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// Cause of the state of a plant's gates.
enum class GateCause : std::uint8_t {
  absent,      ///< no drive has written, or it has ended: gates off
  disabled,    ///< the gate-enable line is off: gates off
  timed_out,   ///< no pattern for `pattern_timeout_ns`: gates off
  locked_out,  ///< no pattern with gates off since one of these: gates off
  late,        ///< no new pattern after `hold_periods`: gates off
  following,   ///< the drive's pattern
};

[[nodiscard]] constexpr const char* to_string(GateCause cause) noexcept {
  switch (cause) {
    case GateCause::absent:
      return "no drive";
    case GateCause::disabled:
      return "the gate-enable line is off";
    case GateCause::timed_out:
      return "the drive has timed out";
    case GateCause::locked_out:
      return "the drive is locked out until it shows gates off";
    case GateCause::late:
      return "a pattern is late";
    case GateCause::following:
      return "the drive's pattern is applied";
  }
  return "?";
}

/// The plant's gate driver: selects the pattern of the coming period. It applies the patterns of a running
/// drive whose gate-enable line is on; without a new one the last pattern is held for `hold_periods`, then
/// the gates turn off until the next pattern.
///
/// A drive that was absent, timed out or without its line is locked out: its patterns are not applied before
/// it has written one with all gates off. A pattern that a control thread writes after a stop in mid-period,
/// or that a network delivers late, was computed for an earlier state of the machine. The drive reads gates
/// off against its pattern and trips (MeasurementAssembler).
class GateGuard {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< plant period [ns]
    int hold_periods{1};             ///< periods for which a pattern is held without a new one [-]
    std::int64_t pattern_timeout_ns{
        5'000'000};          ///< age of the last pattern at which the drive has timed out [ns]
    bool same_clock{false};  ///< drive and plant read one clock, so that patterns have an age [-]
  };

  struct Counters {
    std::uint64_t commands{};    ///< patterns received [-]
    std::uint64_t missing{};     ///< patterns of a drive that were not received [-]
    std::uint64_t outdated{};    ///< patterns received too late to be applied [-]
    std::uint64_t held{};        ///< periods in which the last pattern applied again [-]
    std::uint64_t late{};        ///< times the gates turned off because a pattern was late [-]
    std::uint64_t timed_out{};   ///< times the drive timed out [-]
    std::uint64_t disabled{};    ///< times the gate-enable line went off [-]
    std::uint64_t locked_out{};  ///< times a locked-out drive wrote a driven pattern [-]
    std::uint64_t drives{};      ///< starts of a drive [-]
    std::uint64_t unreadable{};  ///< records without a valid pattern [-]
  };

  explicit GateGuard(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// To be called once a period, at its beginning t_ns [ns]. `fresh`: the pattern received since the last
  /// call, or null. `enabled`: the gate-enable line is on for the drive that writes. `present`: that drive
  /// has not announced its end.
  [[nodiscard]] GatePattern step(std::int64_t t_ns, const DrivePatternRecord* fresh, bool enabled,
                                 bool present) noexcept SEXTANT_NONBLOCKING {
    if (fresh != nullptr && is_outdated(*fresh, t_ns)) {
      ++counters_.outdated;
      fresh = nullptr;
    }
    ++quiet_periods_;
    const bool shows_gates_off = fresh != nullptr && accept(*fresh, t_ns);
    const GateCause before = cause_;
    const bool withdrawn = evaluate_withdrawal(enabled, present);
    if (withdrawn && cause_ != before) armed_ = false;
    if (shows_gates_off) armed_ = true;
    if (!withdrawn) cause_ = evaluate_cause(t_ns, fresh != nullptr);
    report_change(before, enabled);
    const bool acts = cause_ == GateCause::following;
    const bool off_now = !acts || pattern_is_off_;
    if (off_now && !off_) off_since_ns_ = t_ns;
    off_ = off_now;
    return acts ? pattern_ : off();
  }

  [[nodiscard]] GateCause cause() const noexcept SEXTANT_NONBLOCKING { return cause_; }
  /// Whether the last step has changed the cause in a way to be logged.
  [[nodiscard]] bool is_reportable() const noexcept SEXTANT_NONBLOCKING { return is_reportable_; }
  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }
  /// Time from which no leg is driven; meaningful while none is. [ns]
  [[nodiscard]] std::int64_t off_since_ns() const noexcept SEXTANT_NONBLOCKING { return off_since_ns_; }
  /// Time at which the last pattern was received. [ns]
  [[nodiscard]] std::int64_t last_pattern_ns() const noexcept SEXTANT_NONBLOCKING { return last_pattern_ns_; }
  /// Number of the last pattern received. [-]
  [[nodiscard]] std::uint64_t pattern_number() const noexcept SEXTANT_NONBLOCKING { return sequence_; }

 private:
  [[nodiscard]] GatePattern off() const noexcept SEXTANT_NONBLOCKING {
    return GatePattern{gates_off, parameters_.period_ns};
  }

  /// Too old on the common clock. Two periods are the normal delay: one of each side's grid.
  [[nodiscard]] bool is_outdated(const DrivePatternRecord& command,
                                 std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t oldest_ns =
        t_ns - parameters_.pattern_timeout_ns - 2 * std::int64_t{parameters_.period_ns};
    return parameters_.same_clock && command.t_ns < oldest_ns;
  }

  /// Updates the pattern; true for a valid one that drives no leg.
  [[nodiscard]] bool accept(const DrivePatternRecord& command,
                            std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    last_pattern_ns_ = t_ns;
    quiet_periods_ = 0;
    ++counters_.commands;
    if (command.generation != generation_) {
      ++counters_.drives;
      generation_ = command.generation;
      armed_ = false;
      line_was_on_ = false;
    } else if (command.sequence > sequence_ + 1) {
      counters_.missing += command.sequence - sequence_ - 1;
    }
    sequence_ = command.sequence;
    const bool readable = to_pattern(command.pattern, pattern_);
    if (!readable) ++counters_.unreadable;
    if (pattern_.segments().empty()) pattern_ = off();
    pattern_is_off_ = all_gates_off(pattern_);
    return readable && pattern_is_off_;
  }

  /// True, with `cause_`, while the drive is absent, timed out or without its line. The age of the pattern
  /// counts in periods that the plant has run: a stopped plant receives nothing.
  [[nodiscard]] bool evaluate_withdrawal(bool enabled, bool present) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t quiet_ns = quiet_periods_ * parameters_.period_ns;
    if (generation_ == 0 || !present) {
      cause_ = GateCause::absent;
    } else if (quiet_ns > parameters_.pattern_timeout_ns) {
      cause_ = GateCause::timed_out;
    } else if (!enabled) {
      cause_ = GateCause::disabled;
    } else {
      return false;
    }
    return true;
  }

  /// The cause while the drive is present. Gates that are off stay off without a new pattern.
  [[nodiscard]] GateCause evaluate_cause(std::int64_t t_ns, bool fresh) noexcept SEXTANT_NONBLOCKING {
    if (fresh) return armed_ ? GateCause::following : GateCause::locked_out;
    if (cause_ != GateCause::following) return cause_;
    const std::int64_t hold_ns = std::int64_t{parameters_.hold_periods} * parameters_.period_ns;
    if (t_ns - last_pattern_ns_ >= hold_ns) return GateCause::late;
    ++counters_.held;
    return GateCause::following;
  }

  /// Counts a change of the cause, and decides whether it is to be logged: not for late patterns, which are
  /// frequent under desktop scheduling, nor for a line that has never been on.
  void report_change(GateCause before, bool enabled) noexcept SEXTANT_NONBLOCKING {
    is_reportable_ = false;
    const bool line_went_off = line_was_on_ && cause_ == GateCause::disabled;
    if (enabled) line_was_on_ = true;
    if (cause_ == before) return;
    if (cause_ == GateCause::late) ++counters_.late;
    if (cause_ == GateCause::timed_out) ++counters_.timed_out;
    if (cause_ == GateCause::locked_out) ++counters_.locked_out;
    if (line_went_off) ++counters_.disabled;
    const bool was_late = before == GateCause::late && cause_ == GateCause::following;
    is_reportable_ =
        !was_late && cause_ != GateCause::late && (cause_ != GateCause::disabled || line_went_off);
  }

  Parameters parameters_;
  GatePattern pattern_{};
  Counters counters_{};
  GateCause cause_{GateCause::absent};
  std::int64_t last_pattern_ns_{0};
  std::int64_t off_since_ns_{0};
  std::int64_t quiet_periods_{0};  // since the last pattern
  std::uint64_t sequence_{0};
  std::uint32_t generation_{0};
  bool armed_{false};  // the drive has written gates off since its last absence, timeout or line off
  bool line_was_on_{false};
  bool is_reportable_{false};
  bool pattern_is_off_{true};
  bool off_{true};
};

}  // namespace sextant
