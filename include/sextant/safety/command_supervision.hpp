#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/elapsed.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/core/torque_range.hpp"
#include "sextant/safety/command_limits.hpp"
#include "sextant/safety/command_rules.hpp"
#include "sextant/safety/setpoint_ramp.hpp"

namespace sextant {

/// What the command supervision lets through in one period.
template <class T = double>
struct SupervisedCommand {
  T torque{};               ///< the reference for the controller [N·m]
  bool enable{false};       ///< torque production wanted, and the gate agrees
  bool lockout{true};       ///< a valid disable has yet to be seen
  bool fault_reset{false};  ///< true in the one period in which a valid reset arrives, with no command fault
  bool derated{false};      ///< less is admitted than was requested, for want of available torque
  FaultSet faults{};        ///< command faults present now
};

/// The last check between a vehicle's command and the drive. The rules of command_rules.hpp say what is
/// dropped, held, ramped or latched; identity and end-to-end protection were checked on reception, and their
/// result comes with the command. What the rules leave is limited here:
///   silence beyond `timeout`: ramp to zero within `zero_ramp`, heals by itself;
///   silence beyond `lost`: fault, and the lockout returns;
///   enable with a torque beyond `torque_limit` or the contract's range: blocked, the last setpoint holds and
///   nothing else of the frame counts; `blocked_limit` such frames in a row: fault;
///   disable: gates off for this period at least, torque starts again from zero, and the lockout ends unless
///   the frame also resets. Its torque does not matter, so that no disable is blocked. One that a newer
///   command overwrote before this period counts all the same;
///   the torque reference stays within what is available and changes at no more than `torque_rate`.
template <class T = double>
class CommandSupervision {
 public:
  using Parameters = CommandLimits<T>;

  constexpr explicit CommandSupervision(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// One control period at t_ns, dt [s] after the one before. `available` is what the drive can give now;
  /// `zero_requested` asks for a ramp to zero, and holds it there, whatever the command says.
  [[nodiscard]] SupervisedCommand<T> step(const TorqueCommand<T>& command, std::int64_t t_ns, T dt,
                                          TorqueRange<T> available, bool zero_requested) noexcept {
    CommandFacts<T> facts = update_facts(command, t_ns, zero_requested);
    SupervisedCommand<T> out;
    out.fault_reset = evaluate_frames(facts);
    facts.blocked = blocked_;
    const CommandActions actions = evaluate<period_rules<T>>(facts, parameters_);
    out.faults = actions.faults;
    if (out.faults.any()) out.fault_reset = false;
    out.lockout = lockout_;
    out.enable = enable_ && !facts.disabled && !lockout_ && !out.faults.any();
    if (!out.enable) {
      restart();
    } else if (actions.ramp) {
      ramp_to_zero(out, dt, available);
    } else {
      follow(out, dt, available);
    }
    return out;
  }

  /// Demands a valid disable before the next enable, as after power-up and after a fault.
  constexpr void lock() noexcept {
    lockout_ = true;
    setpoint_ = T(0);
    ramp_.reset();
  }

  /// Takes back what was admitted: torque starts again from zero and at its rate.
  constexpr void restart() noexcept {
    ramp_.reset();
    ramping_to_zero_ = false;
  }

 private:
  /// Age and changes of the command since the last period.
  [[nodiscard]] constexpr CommandFacts<T> update_facts(const TorqueCommand<T>& command, std::int64_t t_ns,
                                                       bool zero_requested) noexcept {
    const bool is_new = command.sequence != sequence_;
    const bool disabled = command.disables != disables_;
    const bool reset = command.resets != resets_;
    sequence_ = command.sequence;
    disables_ = command.disables;
    resets_ = command.resets;
    if (is_new) alive_ns_ = command.received_ns;
    // The age of a stamp from the future, or of one before the clock was set back, counts from this period.
    alive_ns_ = std::min(alive_ns_, t_ns);
    return {.command = command,
            .age_ns = elapsed(alive_ns_, t_ns),
            .is_new = is_new,
            .disabled = disabled,
            .reset = reset,
            .zero_requested = zero_requested};
  }

  /// Takes over what the rules leave of the frames that have come; true where one of them resets.
  [[nodiscard]] constexpr bool evaluate_frames(const CommandFacts<T>& facts) noexcept {
    const CommandActions actions = evaluate<frame_rules<T>>(facts, parameters_);
    bool resets = false;
    if (actions.drop) {
      lockout_ = true;
    } else {
      if (facts.disabled) disable(facts.reset || facts.command.fault_reset);
      const bool taken_over = facts.is_new && take_over(facts.command, actions.hold);
      resets = facts.reset || (taken_over && facts.command.fault_reset);
    }
    count_out_of_range(facts.command.out_of_range, facts.is_new);
    return resets;
  }

  /// Takes over a new frame; false where it is blocked.
  constexpr bool take_over(const TorqueCommand<T>& command, bool blocked) noexcept {
    if (!command.enable) {
      disable(command.fault_reset);
    } else if (blocked) {
      ++blocked_;
    } else {
      blocked_ = 0;
      enable_ = true;
      setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
    }
    return !blocked;
  }

  /// A frame that also resets is spent on the reset: the disable that ends the lockout has to come after it.
  /// Where both were overwritten their order is not known, and the lockout stays.
  constexpr void disable(bool resets) noexcept {
    enable_ = false;
    blocked_ = 0;
    setpoint_ = T(0);
    if (!resets) lockout_ = false;
  }

  /// Frames that the receiver dropped for their range are blocked frames as well; it counts them from zero
  /// after each frame that it accepts.
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
    // What is available may fall faster than the torque's own rate.
    out.torque = ramp_.limit(available.lowest, available.highest);
  }

  Parameters parameters_;
  SetpointRamp<T> ramp_{};
  T setpoint_{};
  T zero_rate_{};
  std::int64_t alive_ns_{0};
  std::uint64_t sequence_{0};
  std::uint32_t disables_{0};
  std::uint32_t resets_{0};
  std::uint32_t blocked_{0};       ///< frames in a row, whatever was wrong with their torque [-]
  std::uint32_t out_of_range_{0};  ///< of these, as the receiver last counted them [-]
  bool enable_{false};
  bool lockout_{true};
  bool ramping_to_zero_{false};
};

}  // namespace sextant
