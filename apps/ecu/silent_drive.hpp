#pragma once

#include "sextant/core/telemetry.hpp"

namespace sextant::ecu {

/// What is true of a drive whose control thread is silent (`Crossings::control_silent`): FAULT by WATCHDOG,
/// and no torque on offer. `last` is what that thread said last; its measurements stay as they are, and are
/// of no use to anybody.
[[nodiscard]] inline Telemetry<double> status_of_silent_drive(const Telemetry<double>& last) noexcept {
  Telemetry<double> status = last;
  status.state = DriveState::fault;
  status.lockout = true;
  status.torque = 0.0;
  status.torque_reference = 0.0;
  status.torque_motoring = 0.0;
  status.torque_regenerating = 0.0;
  status.active.set(Fault::watchdog);
  if (!last.latched.any()) status.first_fault = Fault::watchdog;
  if (!last.latched.test(Fault::watchdog)) ++status.fault_total;
  status.latched.set(Fault::watchdog);
  return status;
}

}  // namespace sextant::ecu
