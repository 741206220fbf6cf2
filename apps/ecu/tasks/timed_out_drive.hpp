#pragma once

#include "sextant/core/telemetry.hpp"

namespace sextant::ecu {

/// The status of a drive whose control thread has timed out (`SharedState::control_timed_out`): FAULT by
/// WATCHDOG, no torque available. `last` is the last status of that thread; its measurements are copied and
/// not valid.
[[nodiscard]] inline Telemetry<double> status_of_timed_out_drive(const Telemetry<double>& last) noexcept {
  Telemetry<double> status = last;
  status.state = DriveState::fault;
  status.lockout = true;
  status.torque = 0.0;
  status.torque_reference = 0.0;
  status.torque_motoring = 0.0;
  status.torque_regenerating = 0.0;
  status.derating_cause = DeratingCause::gates_are_off;
  status.active.set(Fault::watchdog);
  if (!last.latched.any()) status.first_fault = Fault::watchdog;
  if (!last.latched.test(Fault::watchdog)) ++status.fault_total;
  status.latched.set(Fault::watchdog);
  return status;
}

}  // namespace sextant::ecu
