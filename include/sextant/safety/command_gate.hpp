#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/elapsed.hpp"
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
  bool fault_reset{false};  ///< true in the one period in which a valid reset arrives, with no command fault
  bool derated{false};      ///< less is admitted than was requested, for want of available torque
  FaultSet faults{};        ///< command faults present now
};

/// The last check between a vehicle's command and the drive: age, range, rate, availability and lockout.
/// Identity and end-to-end protection were checked on reception; their verdict comes with the command.
///   silence beyond `timeout`: ramp to zero within `zero_ramp`, heals by itself;
///   silence beyond `lost`: fault, and the lockout returns;
///   enable with a torque beyond `torque_limit` or the contract's range: blocked, the last setpoint holds and
///   nothing else of the frame counts; three such frames in a row: fault;
///   disable: gates off for this period at least, torque starts again from zero, and the lockout ends unless
///   the frame also resets. Its torque is not looked at, so that no disable is blocked. One that a newer
///   command overwrote before this period counts all the same.
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
    AdmittedCommand<T> out;
    const bool valid = command.e2e == E2eState::valid;
    const bool is_new = command.sequence != sequence_;
    const bool disabled = command.disables != disables_;
    const bool reset = command.resets != resets_;
    disables_ = command.disables;
    resets_ = command.resets;
    if (is_new) alive_ns_ = command.received_ns;
    sequence_ = command.sequence;
    // A stamp from the future must not keep a command alive: it counts from when it was first seen. A clock
    // that was set back makes such stamps as well.
    alive_ns_ = std::min(alive_ns_, t_ns);
    const std::int64_t age_ns = elapsed(alive_ns_, t_ns);
    const bool lost = age_ns > parameters_.lost_ns;
    if (valid && !lost) {
      if (disabled) disable(reset || command.fault_reset);
      const bool new_one_resets = is_new && accept(command);
      out.fault_reset = reset || new_one_resets;
    }
    count_out_of_range(command.out_of_range, is_new);
    if (!valid || lost) lockout_ = true;

    if (lost) out.faults.set(Fault::command_lost);
    if (command.e2e == E2eState::invalid) out.faults.set(Fault::command_invalid);
    if (command.bus_off) out.faults.set(Fault::bus_off);
    if (blocked_ >= parameters_.blocked_limit) out.faults.set(Fault::command_out_of_range);
    if (out.faults.any()) out.fault_reset = false;
    out.lockout = lockout_;
    out.enable = enable_ && !disabled && !lockout_ && !out.faults.any();
    if (!out.enable) {
      restart();
    } else if (age_ns > parameters_.timeout_ns || wind_down) {
      wind_down_to_zero(out, dt, available);
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
    winding_down_ = false;
  }

 private:
  /// Of a NaN, false.
  [[nodiscard]] constexpr bool is_within_limits(const TorqueCommand<T>& command) const noexcept {
    return std::abs(command.torque) <= parameters_.torque_limit && command.torque_limit >= T(0);
  }

  /// Takes a new command; true when it resets.
  constexpr bool accept(const TorqueCommand<T>& command) noexcept {
    if (!command.enable) {
      disable(command.fault_reset);
      return command.fault_reset;
    }
    if (!is_within_limits(command)) {
      ++blocked_;
      return false;
    }
    blocked_ = 0;
    enable_ = true;
    setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
    return command.fault_reset;
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

  constexpr void wind_down_to_zero(AdmittedCommand<T>& out, T dt, TorqueRange<T> available) noexcept {
    if (!winding_down_) zero_rate_ = std::abs(ramp_.value()) / (T(parameters_.zero_ramp_ns) * T(1e-9));
    winding_down_ = true;
    ramp_.step(T(0), std::max(zero_rate_, T(1)) * dt);
    out.torque = ramp_.limit(available.lowest, available.highest);
  }

  constexpr void follow(AdmittedCommand<T>& out, T dt, TorqueRange<T> available) noexcept {
    winding_down_ = false;
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
  bool winding_down_{false};
};

}  // namespace sextant
