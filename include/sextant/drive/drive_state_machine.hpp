#pragma once

#include "sextant/core/drive_state.hpp"

namespace sextant {

/// What the state machine looks at in one period.
struct DriveConditions {
  bool trip{false};               ///< a fault is present that must turn the gates off
  bool fault_reset{false};        ///< a valid reset has arrived
  bool shutdown{false};           ///< the process is leaving
  bool at_zero{false};            ///< the admitted torque has reached zero
  bool lockout{true};             ///< a valid disable has yet to be seen
  bool enable{false};             ///< torque production is wanted and admitted
  bool holds_zero_torque{false};  ///< link voltage and speed allow the machine to be held at zero torque
  bool magnetised{false};         ///< flux is there, or is not waited for
  bool derated{false};            ///< less than the request is admitted
};

[[nodiscard]] constexpr bool makes_torque(DriveState s) noexcept {
  return s == DriveState::torque || s == DriveState::derated;
}

[[nodiscard]] constexpr bool gates_are_on(DriveState s) noexcept {
  return s == DriveState::magnetising || makes_torque(s);
}

/// The state of the coming period. A trip turns the gates off whatever else is asked; a fault is left only by
/// a reset while no fault is present, and then through the lockout. A shutdown waits for the torque to wind
/// down, or for nothing where the gates are off anyway. Where the voltage does not even suffice for zero
/// torque the gates are off; torque returns by itself.
[[nodiscard]] constexpr DriveState next_state(DriveState state, const DriveConditions& c) noexcept {
  if (state == DriveState::shutdown) return state;
  if (c.shutdown && (c.trip || c.at_zero || !gates_are_on(state))) return DriveState::shutdown;
  if (c.trip) return DriveState::fault;
  if (state == DriveState::init) return DriveState::standby;
  if (state == DriveState::fault) return c.fault_reset ? DriveState::standby : state;
  if (c.lockout) return DriveState::standby;
  if (!c.enable || !c.holds_zero_torque) return DriveState::ready;
  if (state == DriveState::standby) return DriveState::ready;
  if (!c.magnetised && state != DriveState::torque && state != DriveState::derated)
    return DriveState::magnetising;
  return c.derated ? DriveState::derated : DriveState::torque;
}

}  // namespace sextant
