#pragma once

#include "sextant/core/drive_state.hpp"

namespace sextant {

/// Inputs of the state machine in one period.
struct DriveConditions {
  bool measured{true};      ///< the measurement is valid
  bool supplied{true};      ///< the link voltage suffices to turn the gates on
  bool trip{false};         ///< a fault is present
  bool fault_reset{false};  ///< a valid reset has arrived
  bool shutdown{false};     ///< shutdown is requested
  bool at_zero{false};      ///< the torque reference is zero
  bool lockout{true};       ///< no enable is accepted before a valid disable
  bool enable{false};       ///< torque production is requested and allowed
  bool magnetised{false};   ///< the flux is ready, or not required
  bool derated{false};      ///< less torque is available than requested, or it lags its reference
};

[[nodiscard]] constexpr bool makes_torque(DriveState s) noexcept {
  return s == DriveState::torque || s == DriveState::derated;
}

[[nodiscard]] constexpr bool gates_are_on(DriveState s) noexcept {
  return s == DriveState::magnetising || makes_torque(s);
}

/// The state of the coming period; the first line that applies wins. A trip turns the gates off; INIT ends
/// with the first valid measurement; FAULT is left by a reset while no fault is present, and then through the
/// lockout. STANDBY lasts until the link is charged; once the gates are on its voltage is a matter of the
/// protections. A shutdown with the gates on waits for a torque reference of zero.
[[nodiscard]] constexpr DriveState next_state(DriveState state, const DriveConditions& c) noexcept {
  if (state == DriveState::shutdown) return state;
  if (c.shutdown && (c.trip || c.at_zero || !gates_are_on(state))) return DriveState::shutdown;
  if (c.trip) return DriveState::fault;
  if (state == DriveState::init) return c.measured ? DriveState::standby : state;
  if (state == DriveState::fault) return c.fault_reset ? DriveState::standby : state;
  if (c.lockout || (!c.supplied && !gates_are_on(state))) return DriveState::standby;
  if (!c.enable) return DriveState::ready;
  if (state == DriveState::standby) return DriveState::ready;
  if (!c.magnetised && state != DriveState::torque && state != DriveState::derated)
    return DriveState::magnetising;
  return c.derated ? DriveState::derated : DriveState::torque;
}

}  // namespace sextant
