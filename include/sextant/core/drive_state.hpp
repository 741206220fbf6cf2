#pragma once

#include <cstdint>

namespace sextant {

/// States of the drive, as MCU_TorqueStatus reports them.
enum class DriveState : std::uint8_t {
  init = 0,         ///< before the first period
  standby = 1,      ///< locked out until a valid disable
  ready = 2,        ///< gates off, an enable is accepted
  magnetising = 3,  ///< building up flux before torque
  torque = 4,       ///< producing the requested torque
  derated = 5,      ///< less torque is available than requested, or the voltage holds it off its reference
  fault = 6,        ///< gates off, latched
  shutdown = 7      ///< gates off, the process ends
};

[[nodiscard]] constexpr const char* to_string(DriveState s) noexcept {
  switch (s) {
    case DriveState::init:
      return "INIT";
    case DriveState::standby:
      return "STANDBY";
    case DriveState::ready:
      return "READY";
    case DriveState::magnetising:
      return "MAGNETISING";
    case DriveState::torque:
      return "TORQUE";
    case DriveState::derated:
      return "DERATED";
    case DriveState::fault:
      return "FAULT";
    case DriveState::shutdown:
      return "SHUTDOWN";
  }
  return "?";
}

}  // namespace sextant
