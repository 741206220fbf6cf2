#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/core/torque_range.hpp"
#include "sextant/safety/setpoint_ramp.hpp"

namespace sextant {

/// What the command gate lets through in one period.
template <class T = double>
struct AdmittedCommand {
  T torque{};               ///< the reference for the controller [N·m]
  bool enable{false};       ///< torque production wanted, and the gate agrees
  bool lockout{true};       ///< a valid disable has yet to be seen
  bool fault_reset{false};  ///< true in the one period in which a valid reset arrives
  bool derated{false};      ///< less is admitted than was requested, for want of available torque
  FaultSet faults{};        ///< command faults present now
};

/// The last check between a vehicle's command and the drive: age, range, rate, availability and lockout.
/// Identity and end-to-end protection were checked on reception; their verdict comes with the command.
///   silence beyond `timeout`: ramp to zero within `zero_ramp`, heals by itself;
///   silence beyond `lost`: fault, and the lockout returns;
///   torque beyond `torque_limit` or the contract's range: blocked, the last setpoint holds; three frames in
///   a row, of either kind: fault. Of a blocked frame only a disable counts: it neither enables nor resets,
///   and lifts no lockout.
template <class T = double>
class CommandGate {
 public:
  struct Parameters {
    T torque_limit{T(150)};                 ///< largest magnitude a command may have [N·m]
    T torque_rate{T(1e6)};                  ///< largest rate of the admitted torque [N·m/s]
    std::int64_t timeout_ns{40'000'000};    ///< age at which the torque starts to ramp to zero [ns]
    std::int64_t zero_ramp_ns{10'000'000};  ///< duration of that ramp, from whatever torque [ns]
    std::int64_t lost_ns{200'000'000};      ///< age at which the command counts as lost [ns]
    std::uint32_t blocked_limit{3};         ///< blocked frames in a row that make a fault [-]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(torque_limit) && torque_limit > T(0))) return "the torque limit must be above zero";
      if (!(std::isfinite(torque_rate) && torque_rate > T(0))) return "the torque rate must be above zero";
      if (timeout_ns <= 0) return "the command timeout must be above zero";
      if (zero_ramp_ns <= 0) return "the ramp to zero must take longer than zero";
      if (lost_ns < timeout_ns) return "a command cannot be lost before it has timed out";
      if (blocked_limit == 0) return "at least one blocked frame makes a fault";
      return nullptr;
    }
  };

  constexpr explicit CommandGate(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// One control period at t_ns, dt [s] after the one before. `available` is what the drive can give now;
  /// `wind_down` asks for a ramp to zero, and holds it there, whatever the command says.
  [[nodiscard]] AdmittedCommand<T> step(const TorqueCommand<T>& command, std::int64_t t_ns, T dt,
                                        TorqueRange<T> available, bool wind_down) noexcept {
    if (is_steady(command, t_ns) && !wind_down) return pass(command, t_ns, dt, available);
    return judge(command, t_ns, dt, available, wind_down);
  }

  /// What `step` does where `is_steady` and there is no `wind_down`.
  [[nodiscard, gnu::always_inline]] AdmittedCommand<T> pass(const TorqueCommand<T>& command,
                                                            std::int64_t t_ns, T dt,
                                                            TorqueRange<T> available) noexcept {
    if (command.sequence != sequence_) [[unlikely]]
      renew(command, t_ns);
    AdmittedCommand<T> out{.enable = true, .lockout = false};
    follow(out, dt, available);
    return out;
  }

  /// True when, where `is_steady`, `pass` would change nothing: the command is known, its setpoint was
  /// admitted last, and a torque of that magnitude is available with `either_way` [N·m], whatever its sign.
  [[nodiscard]] constexpr bool is_settled(const TorqueCommand<T>& command, T either_way) const noexcept {
    return command.sequence == sequence_ && settled_ && std::abs(setpoint_) <= either_way;
  }

  /// What `pass` answers where `is_settled`.
  [[nodiscard]] constexpr AdmittedCommand<T> settled() const noexcept {
    return {.torque = setpoint_, .enable = true, .lockout = false};
  }

  /// True when there is nothing to judge: the bus is well, torque is enabled, and the command is the last one
  /// and young enough, or a new one that asks for nothing but torque within the limits. It is the usual case,
  /// and a short way through it; `judge` would answer the same.
  [[nodiscard, gnu::always_inline]] constexpr bool is_steady(const TorqueCommand<T>& command,
                                                             std::int64_t t_ns) const noexcept {
    if (!follows_ || command.e2e != E2eState::valid) return false;
    if ((unsigned(command.bus_off) | command.out_of_range) != 0) return false;  // one branch for both
    if (command.sequence == sequence_) return t_ns - alive_ns_ <= parameters_.timeout_ns;
    return command.sequence != 0 && command.enable && !command.fault_reset && is_within_limits(command) &&
           t_ns - command.received_ns <= parameters_.timeout_ns;
  }

  /// Demands a valid disable before the next enable, as after power-up and after a fault.
  constexpr void lock() noexcept {
    lockout_ = true;
    follows_ = false;
    settled_ = false;
    setpoint_ = T(0);
    ramp_.reset();
  }

  /// Takes back what was admitted: torque starts again from zero and at its rate.
  constexpr void restart() noexcept {
    ramp_.reset();
    settled_ = false;
  }

 private:
  [[nodiscard, gnu::noinline]] AdmittedCommand<T> judge(const TorqueCommand<T>& command, std::int64_t t_ns,
                                                        T dt, TorqueRange<T> available,
                                                        bool wind_down) noexcept {
    AdmittedCommand<T> out;
    const bool valid = command.sequence != 0 && command.e2e == E2eState::valid;
    const bool is_new = command.sequence != sequence_;
    // A stamp from the future must not keep a command alive: it counts from when it was first seen.
    if (is_new) alive_ns_ = std::min(command.received_ns, t_ns);
    sequence_ = command.sequence;
    const std::int64_t age_ns = t_ns - alive_ns_;
    const bool lost = age_ns > parameters_.lost_ns;
    if (valid && is_new && !lost) accept(command, out);
    count_out_of_range(command.out_of_range, is_new);
    if (!valid || lost) lockout_ = true;

    if (lost) out.faults.set(Fault::command_lost);
    if (command.e2e == E2eState::invalid) out.faults.set(Fault::command_invalid);
    if (command.bus_off) out.faults.set(Fault::bus_off);
    if (blocked_ >= parameters_.blocked_limit) out.faults.set(Fault::command_out_of_range);
    out.lockout = lockout_;
    out.enable = enable_ && !lockout_ && !out.faults.any();
    if (age_ns > parameters_.timeout_ns || wind_down || !out.enable) {
      wind_down_to_zero(out, dt);
    } else {
      follow(out, dt, available);
    }
    if (winding_down_) settled_ = false;
    follows_ = out.enable && !winding_down_ && out_of_range_ == 0;
    return out;
  }

  /// Of a NaN, false.
  [[nodiscard]] constexpr bool is_within_limits(const TorqueCommand<T>& command) const noexcept {
    return std::abs(command.torque) <= parameters_.torque_limit && command.torque_limit >= T(0);
  }

  /// Takes a new command over another that is like it in all but torque and time.
  constexpr void renew(const TorqueCommand<T>& command, std::int64_t t_ns) noexcept {
    // A stamp from the future must not keep a command alive: it counts from when it was first seen.
    alive_ns_ = std::min(command.received_ns, t_ns);
    sequence_ = command.sequence;
    blocked_ = 0;
    settled_ = false;
    setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
  }

  constexpr void accept(const TorqueCommand<T>& command, AdmittedCommand<T>& out) noexcept {
    if (!command.enable) enable_ = false;
    if (!is_within_limits(command)) {
      ++blocked_;
      return;
    }
    blocked_ = 0;
    enable_ = command.enable;
    out.fault_reset = command.fault_reset;
    // A frame that also resets is spent on the reset: the disable has to come after it.
    if (!command.enable && !command.fault_reset) lockout_ = false;
    setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
  }

  /// Frames that the receiver dropped for their range are blocked frames as well; it counts them from zero
  /// after each frame that it accepts.
  constexpr void count_out_of_range(std::uint32_t in_a_row, bool accepted_one) noexcept {
    if (accepted_one || in_a_row < out_of_range_) out_of_range_ = 0;
    blocked_ += in_a_row - out_of_range_;
    out_of_range_ = in_a_row;
  }

  constexpr void wind_down_to_zero(AdmittedCommand<T>& out, T dt) noexcept {
    if (!winding_down_) zero_rate_ = std::abs(ramp_.value()) / (T(parameters_.zero_ramp_ns) * T(1e-9));
    winding_down_ = true;
    out.torque = ramp_.step(T(0), std::max(zero_rate_, T(1)) * dt);
  }

  constexpr void follow(AdmittedCommand<T>& out, T dt, TorqueRange<T> available) noexcept {
    winding_down_ = false;
    const T target = std::clamp(setpoint_, available.lowest, available.highest);
    out.derated = target != setpoint_;
    out.torque = ramp_.step(target, parameters_.torque_rate * dt);
    settled_ = out.torque == setpoint_;
  }

  Parameters parameters_;
  SetpointRamp<T> ramp_{};
  T setpoint_{};
  T zero_rate_{};
  std::int64_t alive_ns_{0};
  std::uint32_t sequence_{0};
  std::uint32_t blocked_{0};       ///< frames in a row, whatever was wrong with their torque [-]
  std::uint32_t out_of_range_{0};  ///< of these, as the receiver last counted them [-]
  bool enable_{false};
  bool lockout_{true};
  bool winding_down_{false};
  bool settled_{false};  ///< what was admitted last is the setpoint
  bool follows_{false};  ///< the command was followed when it was last judged, with nothing against it
};

}  // namespace sextant
