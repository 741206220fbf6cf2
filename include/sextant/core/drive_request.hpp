#pragma once

#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// The inputs of one period beside the measurement: the vehicle's command, shutdown, and the faults that the
/// process detects.
template <class T = double>
struct DriveRequest {
  TorqueCommand<T> command{};
  bool shutdown{false};  ///< ramp to zero, then gates off for good
  FaultSet external{};   ///< faults detected outside the drive: watchdog, second_master
};

}  // namespace sextant
