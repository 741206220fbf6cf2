#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// What decides over the gates of a plant.
enum class GateCause : std::uint8_t {
  absent,      ///< no drive has written yet, or it has left: open
  disabled,    ///< the gate-enable line is off: open
  timed_out,   ///< the drive's heartbeat stopped: open
  locked_out,  ///< the drive has not shown gates off since one of those: open
  late,        ///< the next pattern is missing, the last one has been held as long as it may: open
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
      return "the drive's pattern acts";
  }
  return "?";
}

/// The plant's gate driver: which pattern acts over the coming period. It follows a drive that lives and has
/// its gate-enable line on; a pattern that is not renewed is held for `hold_periods`, then the gates turn off
/// and the next pattern may close them.
///
/// A drive that was absent, timed out or without its line is locked out: nothing closes the gates before it
/// has shown a pattern with all of them off. What a control thread that was stopped in the middle of a period
/// writes when it goes on, and what a network delivers late of a dead drive, is torque for a machine of the
/// past. The drive sees gates off against its pattern and trips (MeasurementAssembler).
class GateGuard {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< plant period [ns]
    int hold_periods{1};             ///< periods for which a pattern acts that is not renewed [-]
    std::int64_t pattern_timeout_ns{
        5'000'000};          ///< without a pattern for so long the drive counts as dead [ns]
    bool same_clock{false};  ///< the drive's clock is the plant's: a pattern's age can be told [-]
  };

  struct Counters {
    std::uint64_t commands{};    ///< patterns taken [-]
    std::uint64_t missing{};     ///< patterns of a drive that were never taken [-]
    std::uint64_t outdated{};    ///< patterns that came when they were too old [-]
    std::uint64_t held{};        ///< periods in which the last pattern applied again [-]
    std::uint64_t late{};        ///< times the gates turned off because a pattern was late [-]
    std::uint64_t timed_out{};   ///< times the drive timed out [-]
    std::uint64_t disabled{};    ///< times the gate-enable line went off [-]
    std::uint64_t locked_out{};  ///< times a drive wrote torque that had to show gates off first [-]
    std::uint64_t drives{};      ///< starts of a drive that have been seen [-]
    std::uint64_t unreadable{};  ///< patterns that described none [-]
  };

  explicit GateGuard(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// To be called once a period, at its beginning t_ns [ns]. `fresh`: the command that has come since the
  /// last call, or null. `enabled`: the gate-enable line is on for the drive that writes. `present`: that
  /// drive has not said that it leaves.
  [[nodiscard]] GatePattern step(std::int64_t t_ns, const DrivePatternRecord* fresh, bool enabled,
                                 bool present) noexcept SEXTANT_NONBLOCKING {
    if (fresh != nullptr && is_outdated(*fresh, t_ns)) {
      ++counters_.outdated;
      fresh = nullptr;
    }
    ++quiet_periods_;
    const bool shows_open_gates = fresh != nullptr && take(*fresh, t_ns);
    const GateCause before = cause_;
    const bool withdrawn = judge_withdrawal(enabled, present);
    if (withdrawn && cause_ != before) armed_ = false;
    if (shows_open_gates) armed_ = true;
    if (!withdrawn) cause_ = judge(t_ns, fresh != nullptr);
    settle(before, enabled);
    const bool acts = cause_ == GateCause::following;
    const bool off_now = !acts || pattern_is_off_;
    if (off_now && !off_) open_since_ns_ = t_ns;
    off_ = off_now;
    return acts ? pattern_ : off();
  }

  [[nodiscard]] GateCause cause() const noexcept SEXTANT_NONBLOCKING { return cause_; }
  /// Whether the last step has changed what decides, in a way that people want to know.
  [[nodiscard]] bool has_news() const noexcept SEXTANT_NONBLOCKING { return has_news_; }
  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }
  /// Since when no leg is driven; meaningful while none is. [ns]
  [[nodiscard]] std::int64_t open_since_ns() const noexcept SEXTANT_NONBLOCKING { return open_since_ns_; }
  /// When the last command was taken. [ns]
  [[nodiscard]] std::int64_t heard_ns() const noexcept SEXTANT_NONBLOCKING { return heard_ns_; }
  /// Number of the command taken last. [-]
  [[nodiscard]] std::uint64_t pattern_number() const noexcept SEXTANT_NONBLOCKING { return sequence_; }

 private:
  [[nodiscard]] GatePattern off() const noexcept SEXTANT_NONBLOCKING {
    return GatePattern{gates_off, parameters_.period_ns};
  }

  /// Two periods pass even when nobody is late, one of either side's grid.
  [[nodiscard]] bool is_outdated(const DrivePatternRecord& command,
                                 std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t oldest_ns =
        t_ns - parameters_.pattern_timeout_ns - 2 * std::int64_t{parameters_.period_ns};
    return parameters_.same_clock && command.t_ns < oldest_ns;
  }

  /// True when the command shows gates off: a readable pattern that drives no leg.
  [[nodiscard]] bool take(const DrivePatternRecord& command, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    heard_ns_ = t_ns;
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

  /// True, with its cause, when the drive has lost the gates until it has shown them open. Periods count that
  /// the plant has run: while it stood still itself it could not hear anybody.
  [[nodiscard]] bool judge_withdrawal(bool enabled, bool present) noexcept SEXTANT_NONBLOCKING {
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

  /// Without a fresh pattern an open gate stays open.
  [[nodiscard]] GateCause judge(std::int64_t t_ns, bool fresh) noexcept SEXTANT_NONBLOCKING {
    if (fresh) return armed_ ? GateCause::following : GateCause::locked_out;
    if (cause_ != GateCause::following) return cause_;
    const std::int64_t hold_ns = std::int64_t{parameters_.hold_periods} * parameters_.period_ns;
    if (t_ns - heard_ns_ >= hold_ns) return GateCause::late;
    ++counters_.held;
    return GateCause::following;
  }

  /// Counts a change, and says whether it is news. Late patterns come and go with the scheduling of a
  /// desktop, and a line that has never been on has not gone off.
  void settle(GateCause before, bool enabled) noexcept SEXTANT_NONBLOCKING {
    has_news_ = false;
    const bool line_went_off = line_was_on_ && cause_ == GateCause::disabled;
    if (enabled) line_was_on_ = true;
    if (cause_ == before) return;
    if (cause_ == GateCause::late) ++counters_.late;
    if (cause_ == GateCause::timed_out) ++counters_.timed_out;
    if (cause_ == GateCause::locked_out) ++counters_.locked_out;
    if (line_went_off) ++counters_.disabled;
    const bool hiccup = before == GateCause::late && cause_ == GateCause::following;
    has_news_ = !hiccup && cause_ != GateCause::late && (cause_ != GateCause::disabled || line_went_off);
  }

  Parameters parameters_;
  GatePattern pattern_{};
  Counters counters_{};
  GateCause cause_{GateCause::absent};
  std::int64_t heard_ns_{0};
  std::int64_t open_since_ns_{0};
  std::int64_t quiet_periods_{0};  // without a pattern
  std::uint64_t sequence_{0};
  std::uint32_t generation_{0};
  bool armed_{false};  // the drive has shown gates off since it lost them
  bool line_was_on_{false};
  bool has_news_{false};
  bool pattern_is_off_{true};
  bool off_{true};
};

}  // namespace sextant
