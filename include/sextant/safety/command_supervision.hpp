#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/derating_cause.hpp"
#include "sextant/core/elapsed.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/core/torque_range.hpp"
#include "sextant/safety/command_limits.hpp"
#include "sextant/safety/command_rules.hpp"
#include "sextant/safety/setpoint_ramp.hpp"

namespace sextant {

/// Output of the command supervision in one period.
template <class T = double>
struct SupervisedCommand {
  T torque{};               ///< torque reference [N·m]
  T setpoint{};             ///< accepted request, within its limit, which the reference follows [N·m]
  bool enable{false};       ///< torque production requested and allowed
  bool lockout{true};       ///< no enable is accepted before a valid disable
  bool fault_reset{false};  ///< true in the one period after a valid reset, with no command fault
  bool derated{false};      ///< less torque is available than requested
  DeratingCause ramp{DeratingCause::none};  ///< by which the reference ramps to zero, or stays there
  FaultSet faults{};                        ///< command faults present
};

/// Command supervision: turns a vehicle's command into the torque reference. CommandReceiver has checked
/// identity and end-to-end protection; the command carries the result. The rules of command_rules.hpp drop,
/// hold, ramp or latch; this class applies their actions and limits the reference:
///   age above `timeout`: ramp to zero within `zero_ramp`; the next command ends it;
///   age above `lost`: fault, and the lockout returns;
///   status frames not sent for `status_timeout`: the same ramp; for `status_lost`: fault;
///   enable with a torque beyond `torque_limit` or the contract's range: the frame is blocked, and the
///   setpoint before it holds; `blocked_limit` such frames in a row: fault;
///   disable, with any torque: gates off for this period at least, torque starts again from zero, and the
///   lockout ends unless the frame also resets. A disable that a newer command overwrote unread has the same
///   effect;
///   the torque reference stays within the available torque and changes by at most `torque_rate`.
template <class T = double>
class CommandSupervision {
 public:
  using Parameters = CommandLimits<T>;

  constexpr explicit CommandSupervision(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// One control period at t_ns, dt [s] after the one before. `available`: the torques available in this
  /// period. `zero`: where it is not none, the reference ramps to zero and stays there, for any command.
  /// `status_age_ns`: since a status frame was last sent, 0 without a bus [ns].
  [[nodiscard]] SupervisedCommand<T> step(const TorqueCommand<T>& command, std::int64_t t_ns, T dt,
                                          TorqueRange<T> available, ZeroRequest zero,
                                          std::int64_t status_age_ns = 0) noexcept {
    CommandFacts<T> facts = update_facts(command, t_ns, zero, status_age_ns);
    SupervisedCommand<T> out;
    out.fault_reset = evaluate_frames(facts);
    facts.blocked = blocked_;
    const CommandActions actions = evaluate<period_rules<T>>(facts, parameters_);
    out.faults = actions.faults;
    if (out.faults.any()) out.fault_reset = false;
    out.lockout = lockout_;
    out.enable = enable_ && !facts.disabled && !lockout_ && !out.faults.any();
    out.setpoint = setpoint_;
    if (!out.enable) {
      restart();
    } else if (actions.ramp) {
      out.ramp = actions.cause;
      ramp_to_zero(out, dt, available);
    } else {
      follow(out, dt, available);
    }
    return out;
  }

  /// Takes the limits of another one between two periods; command, reference and lockout stay.
  constexpr void take_parameters(const CommandSupervision& from) noexcept { parameters_ = from.parameters_; }

  /// Sets the lockout: no enable is accepted before a valid disable, as after power-up.
  constexpr void lock() noexcept {
    lockout_ = true;
    setpoint_ = T(0);
    ramp_.reset();
  }

  /// Sets the torque reference to zero: it starts again from there at its rate.
  constexpr void restart() noexcept {
    ramp_.reset();
    ramping_to_zero_ = false;
  }

 private:
  /// Age and changes of the command since the last period.
  [[nodiscard]] constexpr CommandFacts<T> update_facts(const TorqueCommand<T>& command, std::int64_t t_ns,
                                                       ZeroRequest zero,
                                                       std::int64_t status_age_ns) noexcept {
    const bool is_new = command.sequence != sequence_;
    const bool disabled = command.disables != disables_;
    // A frame that enables is never a reset.
    const bool resets_now = is_new && !command.enable && command.fault_reset;
    const bool reset = command.resets != resets_ || resets_now;
    sequence_ = command.sequence;
    disables_ = command.disables;
    resets_ = command.resets;
    if (is_new) age_from_ns_ = command.received_ns;
    // A time stamp later than this period, as after the clock was set back, counts as this period's.
    age_from_ns_ = std::min(age_from_ns_, t_ns);
    return {.command = command,
            .age_ns = elapsed(age_from_ns_, t_ns),
            .status_age_ns = status_age_ns,
            .is_new = is_new,
            .disabled = disabled,
            .reset = reset,
            .zero = zero};
  }

  /// Applies the rules and the effects of the frames since the last period; true where one resets.
  [[nodiscard]] constexpr bool evaluate_frames(const CommandFacts<T>& facts) noexcept {
    const CommandActions actions = evaluate<frame_rules<T>>(facts, parameters_);
    if (actions.drop) {
      lockout_ = true;
    } else {
      if (facts.disabled) disable(facts.reset);
      if (facts.is_new) take_over(facts.command, actions.hold);
    }
    count_out_of_range(facts.command.out_of_range, facts.is_new);
    return facts.reset && !actions.drop;
  }

  /// Takes over a new frame; of one that is blocked nothing counts.
  constexpr void take_over(const TorqueCommand<T>& command, bool blocked) noexcept {
    if (!command.enable) {
      disable(command.fault_reset);
    } else if (blocked) {
      ++blocked_;
    } else {
      blocked_ = 0;
      enable_ = true;
      setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
    }
  }

  /// A disable that also resets leaves the lockout in place: a disable after it ends the lockout. Where both
  /// were overwritten unread their order is unknown, and the lockout stays.
  constexpr void disable(bool resets) noexcept {
    enable_ = false;
    blocked_ = 0;
    setpoint_ = T(0);
    if (!resets) lockout_ = false;
  }

  /// Frames that the receiver rejected for their range count as blocked frames; the receiver counts them from
  /// zero after each accepted frame.
  constexpr void count_out_of_range(std::uint32_t in_a_row, bool accepted_one) noexcept {
    if (accepted_one || in_a_row < out_of_range_) out_of_range_ = 0;
    blocked_ += in_a_row - out_of_range_;
    out_of_range_ = in_a_row;
  }

  constexpr void ramp_to_zero(SupervisedCommand<T>& out, T dt, TorqueRange<T> available) noexcept {
    if (!ramping_to_zero_) zero_rate_ = std::abs(ramp_.value()) / (T(parameters_.zero_ramp_ns) * T(1e-9));
    ramping_to_zero_ = true;
    ramp_.step(T(0), std::max(zero_rate_, T(1)) * dt);
    out.torque = ramp_.limit(available.lowest, available.highest);
  }

  constexpr void follow(SupervisedCommand<T>& out, T dt, TorqueRange<T> available) noexcept {
    ramping_to_zero_ = false;
    const T target = std::clamp(setpoint_, available.lowest, available.highest);
    out.derated = target != setpoint_;
    ramp_.step(target, parameters_.torque_rate * dt);
    // The available torque may fall faster than `torque_rate`.
    out.torque = ramp_.limit(available.lowest, available.highest);
  }

  Parameters parameters_;
  SetpointRamp<T> ramp_{};
  T setpoint_{};
  T zero_rate_{};
  std::int64_t age_from_ns_{0};
  std::uint64_t sequence_{0};
  std::uint32_t disables_{0};
  std::uint32_t resets_{0};
  std::uint32_t blocked_{0};       ///< blocked frames in a row [-]
  std::uint32_t out_of_range_{0};  ///< of these, by the receiver's last count [-]
  bool enable_{false};
  bool lockout_{true};
  bool ramping_to_zero_{false};
};

}  // namespace sextant
