#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// What decides over the gates of a plant.
enum class GateCause : std::uint8_t {
  absent,     ///< no drive has written yet, or it has left: open
  disabled,   ///< the gate-enable line is off: open
  silent,     ///< the drive's heartbeat stopped: open
  late,       ///< the next pattern is missing, the last one has been held as long as it may: open
  following,  ///< the drive's pattern
};

[[nodiscard]] constexpr const char* to_string(GateCause cause) noexcept {
  switch (cause) {
    case GateCause::absent:
      return "no drive";
    case GateCause::disabled:
      return "the gate-enable line is off";
    case GateCause::silent:
      return "the drive is silent";
    case GateCause::late:
      return "a pattern is late";
    case GateCause::following:
      return "the drive's pattern acts";
  }
  return "?";
}

/// The plant's gate driver: which pattern acts over the coming period. It follows a drive that lives and has
/// its gate-enable line on; a pattern that is not renewed is held for `hold_periods`, then the gates open.
class GateGuard {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};      ///< plant period [ns]
    int hold_periods{1};                 ///< periods for which a pattern acts that is not renewed [-]
    std::int64_t silence_ns{5'000'000};  ///< without a pattern for so long the drive counts as dead [ns]
  };

  struct Counters {
    std::uint64_t commands{};    ///< patterns taken [-]
    std::uint64_t missing{};     ///< patterns of a drive that never came [-]
    std::uint64_t held{};        ///< periods in which the last pattern acted again [-]
    std::uint64_t late{};        ///< times the gates opened because a pattern was late [-]
    std::uint64_t silent{};      ///< times the drive fell silent [-]
    std::uint64_t disabled{};    ///< times the gate-enable line went off [-]
    std::uint64_t drives{};      ///< starts of a drive that have been seen [-]
    std::uint64_t unreadable{};  ///< patterns that described none [-]
  };

  explicit GateGuard(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// To be called once a period, at its beginning t_ns [ns]. `fresh`: the command that has come since the
  /// last call, or null. `enabled`: the gate-enable line is on for the drive that writes. `present`: that
  /// drive has not said that it leaves.
  [[nodiscard]] GatePattern step(std::int64_t t_ns, const CommandRecord* fresh, bool enabled,
                                 bool present) noexcept SEXTANT_NONBLOCKING {
    if (fresh != nullptr) take(*fresh, t_ns);
    const GateCause before = cause_;
    cause_ = judge(t_ns, fresh != nullptr, enabled, present);
    count(before);
    const GatePattern acts = cause_ == GateCause::following ? pattern_ : off();
    const bool off_now = all_gates_off(acts);
    if (off_now && !off_) open_since_ns_ = t_ns;
    off_ = off_now;
    return acts;
  }

  [[nodiscard]] GateCause cause() const noexcept SEXTANT_NONBLOCKING { return cause_; }
  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }
  /// Since when no leg is driven; meaningful while none is. [ns]
  [[nodiscard]] std::int64_t open_since_ns() const noexcept SEXTANT_NONBLOCKING { return open_since_ns_; }
  /// When the last command was taken. [ns]
  [[nodiscard]] std::int64_t heard_ns() const noexcept SEXTANT_NONBLOCKING { return heard_ns_; }
  [[nodiscard]] std::uint64_t command_sequence() const noexcept SEXTANT_NONBLOCKING { return sequence_; }

 private:
  [[nodiscard]] GatePattern off() const noexcept SEXTANT_NONBLOCKING {
    return GatePattern{gates_off, parameters_.period_ns};
  }

  void take(const CommandRecord& command, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    heard_ns_ = t_ns;
    periods_old_ = 0;
    ++counters_.commands;
    if (command.generation != generation_) {
      ++counters_.drives;
      generation_ = command.generation;
    } else if (command.sequence > sequence_ + 1) {
      counters_.missing += command.sequence - sequence_ - 1;
    }
    sequence_ = command.sequence;
    if (!to_pattern(command.pattern, pattern_)) ++counters_.unreadable;
    if (pattern_.segments().empty()) pattern_ = off();
  }

  [[nodiscard]] GateCause judge(std::int64_t t_ns, bool fresh, bool enabled,
                                bool present) noexcept SEXTANT_NONBLOCKING {
    if (generation_ == 0 || !present) return GateCause::absent;
    if (t_ns - heard_ns_ > parameters_.silence_ns) return GateCause::silent;
    if (!enabled) return GateCause::disabled;
    if (fresh) return GateCause::following;
    ++periods_old_;
    if (periods_old_ >= parameters_.hold_periods || cause_ != GateCause::following) return stays_open();
    ++counters_.held;
    return GateCause::following;
  }

  /// Without a fresh pattern an open gate stays open.
  [[nodiscard]] GateCause stays_open() const noexcept SEXTANT_NONBLOCKING {
    return cause_ == GateCause::following ? GateCause::late : cause_;
  }

  void count(GateCause before) noexcept SEXTANT_NONBLOCKING {
    if (cause_ == before) return;
    if (cause_ == GateCause::late) ++counters_.late;
    if (cause_ == GateCause::silent) ++counters_.silent;
    if (cause_ == GateCause::disabled) ++counters_.disabled;
  }

  Parameters parameters_;
  GatePattern pattern_{};
  Counters counters_{};
  GateCause cause_{GateCause::absent};
  std::int64_t heard_ns_{0};
  std::int64_t open_since_ns_{0};
  std::uint64_t sequence_{0};
  std::uint32_t generation_{0};
  int periods_old_{0};
  bool off_{true};
};

}  // namespace sextant
