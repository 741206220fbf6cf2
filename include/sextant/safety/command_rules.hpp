#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/derating_cause.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/safety/command_limits.hpp"
#include "sextant/safety/rule_table.hpp"
#include "sextant/safety/zero_request.hpp"

namespace sextant {

/// Inputs of the rules of the command supervision in one control period.
template <class T = double>
struct CommandFacts {
  const TorqueCommand<T>& command;
  std::int64_t age_ns{};         ///< since the newest accepted frame was received [ns]
  std::int64_t status_age_ns{};  ///< since a status frame was last sent [ns]
  bool is_new{false};            ///< the newest frame came since the last period
  bool disabled{false};          ///< a frame with Enable = 0 has come since the last period
  bool reset{false};             ///< a disable with FaultReset = 1 has come since the last period
  ZeroRequest zero{};            ///< for what the drive requires zero torque
  std::uint32_t blocked{};       ///< blocked frames in a row [-]
};

/// The action of a rule that applies.
enum class CommandAction : std::uint8_t {
  drop,   ///< the frame has no effect, and the lockout returns
  hold,   ///< the frame is blocked: the setpoint before it holds
  ramp,   ///< the torque reference ramps to zero
  latch,  ///< the rule's fault is present
};

/// One rule: where `applies` is true, `action` follows.
template <class T = double>
struct CommandRule {
  CommandAction action{};
  bool (*applies)(const CommandFacts<T>&, const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING{};
  Fault fault{};                             ///< of action `latch`
  DeratingCause cause{DeratingCause::none};  ///< of action `ramp`
};

namespace command_rule {

template <class T>
[[nodiscard]] constexpr bool e2e_is_not_valid(const CommandFacts<T>& facts,
                                              const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.command.e2e != E2eState::valid;
}

template <class T>
[[nodiscard]] constexpr bool e2e_is_invalid(const CommandFacts<T>& facts,
                                            const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.command.e2e == E2eState::invalid;
}

template <class T>
[[nodiscard]] constexpr bool is_lost(const CommandFacts<T>& facts,
                                     const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.age_ns > limits.lost_ns;
}

template <class T>
[[nodiscard]] constexpr bool has_timed_out(const CommandFacts<T>& facts,
                                           const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.age_ns > limits.timeout_ns;
}

/// A new frame that enables with a torque that is NaN or beyond `torque_limit`, or with a negative limit. A
/// disable is never out of range.
template <class T>
[[nodiscard]] constexpr bool is_out_of_range(const CommandFacts<T>& facts,
                                             const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  const TorqueCommand<T>& c = facts.command;
  const bool in_range = std::abs(c.torque) <= limits.torque_limit && c.torque_limit >= T(0);
  return facts.is_new && c.enable && !in_range;
}

template <class T>
[[nodiscard]] constexpr bool is_blocked_in_a_row(
    const CommandFacts<T>& facts, const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.blocked >= limits.blocked_limit;
}

template <class T>
[[nodiscard]] constexpr bool is_bus_off(const CommandFacts<T>& facts,
                                        const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.command.bus_off;
}

/// Another VCU sends under the command's identifier.
template <class T>
[[nodiscard]] constexpr bool has_second_sender(const CommandFacts<T>& facts,
                                               const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.command.second_sender;
}

template <class T>
[[nodiscard]] constexpr bool status_has_timed_out(
    const CommandFacts<T>& facts, const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.status_age_ns > limits.status_timeout_ns;
}

template <class T>
[[nodiscard]] constexpr bool status_is_lost(const CommandFacts<T>& facts,
                                            const CommandLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.status_age_ns > limits.status_lost_ns;
}

template <class T>
[[nodiscard]] constexpr bool shutdown_is_requested(const CommandFacts<T>& facts,
                                                   const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.zero == ZeroRequest::shutdown;
}

template <class T>
[[nodiscard]] constexpr bool flux_is_awaited(const CommandFacts<T>& facts,
                                             const CommandLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  return facts.zero == ZeroRequest::awaits_flux;
}

}  // namespace command_rule

/// Rules on the frames since the last period, evaluated before a frame has an effect.
template <class T = double>
inline constexpr std::array frame_rules{
    CommandRule<T>{CommandAction::drop, command_rule::e2e_is_not_valid<T>},
    CommandRule<T>{CommandAction::drop, command_rule::is_lost<T>},
    CommandRule<T>{CommandAction::hold, command_rule::is_out_of_range<T>},
};

/// Rules on the command in force, evaluated after the frames.
template <class T = double>
inline constexpr std::array period_rules{
    CommandRule<T>{CommandAction::ramp, command_rule::has_timed_out<T>, {}, DeratingCause::command_timeout},
    CommandRule<T>{
        CommandAction::ramp, command_rule::status_has_timed_out<T>, {}, DeratingCause::status_timeout},
    CommandRule<T>{CommandAction::ramp, command_rule::shutdown_is_requested<T>, {}, DeratingCause::shutdown},
    CommandRule<T>{CommandAction::ramp, command_rule::flux_is_awaited<T>},
    CommandRule<T>{CommandAction::latch, command_rule::is_lost<T>, Fault::command_lost},
    CommandRule<T>{CommandAction::latch, command_rule::e2e_is_invalid<T>, Fault::command_invalid},
    CommandRule<T>{CommandAction::latch, command_rule::is_blocked_in_a_row<T>, Fault::command_out_of_range},
    CommandRule<T>{CommandAction::latch, command_rule::is_bus_off<T>, Fault::bus_off},
    CommandRule<T>{CommandAction::latch, command_rule::has_second_sender<T>, Fault::second_master},
    CommandRule<T>{CommandAction::latch, command_rule::status_is_lost<T>, Fault::transmit_lost},
};

/// The actions of all rules that apply.
struct CommandActions {
  bool drop{false};
  bool hold{false};
  bool ramp{false};
  DeratingCause cause{DeratingCause::none};  ///< of the first rule that ramps
  FaultSet faults{};

  template <class T>
  constexpr void add(const CommandRule<T>& rule) noexcept {
    drop |= rule.action == CommandAction::drop;
    hold |= rule.action == CommandAction::hold;
    if (rule.action == CommandAction::ramp && !ramp) cause = rule.cause;
    ramp |= rule.action == CommandAction::ramp;
    if (rule.action == CommandAction::latch) faults.set(rule.fault);
  }
};

/// Evaluates every rule of the table, in order; returns the actions of those that apply.
template <const auto& rules, class T>
[[nodiscard]] constexpr CommandActions evaluate(const CommandFacts<T>& facts,
                                                const CommandLimits<T>& limits) noexcept {
  CommandActions actions;
  for_each_rule<rules>([&]<std::size_t n>() {
    if (rules[n].applies(facts, limits)) actions.add(rules[n]);
  });
  return actions;
}

}  // namespace sextant
