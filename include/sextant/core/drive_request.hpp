#pragma once

#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// Everything that is asked of the drive in one period: the vehicle's command and what the process around
/// the drive has to say.
template <class T = double>
struct DriveRequest {
  TorqueCommand<T> command{};
  bool shutdown{false};  ///< ramp to zero, then gates off for good
  FaultSet external{};   ///< faults that only the surroundings can see: overrun, watchdog, transmit_lost
};

}  // namespace sextant
