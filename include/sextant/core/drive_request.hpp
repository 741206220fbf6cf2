#pragma once

#include <cstdint>

#include "sextant/core/fault.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// The inputs of one period beside the measurement: the vehicle's command, shutdown, and the faults that the
/// process detects.
template <class T = double>
struct DriveRequest {
  TorqueCommand<T> command{};
  bool shutdown{false};           ///< ramp to zero, then gates off for good
  std::int64_t status_age_ns{0};  ///< since a status frame was last sent; 0 without a bus [ns]
  FaultSet external{};            ///< faults detected outside the drive: watchdog, overrun, second_master
};

}  // namespace sextant
