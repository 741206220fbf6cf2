#pragma once

#include <cstdint>

namespace sextant {

/// What limits the torque; the values are those of `DeratingCause` in the CAN contract.
enum class DeratingCause : std::uint8_t {
  none = 0,           ///< nothing but configured limits of the torque
  current_limit = 1,  ///< the drive's limit of the stator current
  voltage_limit = 2,  ///< the voltage of the link, or the breakdown torque at a flux below the configured one
  temperature = 3,    ///< the winding's, measured or by its thermal model
  dc_link_low = 4,    ///< the link voltage, to which motoring power is limited, or which STANDBY waits for
  gates_are_off = 5,  ///< GATES_OFF in the contract: the torque is available after an enable
  // The torque is available, and the reference ramps to zero:
  command_timeout = 6,  ///< the last command is too old
  status_timeout = 7,   ///< the bus takes no status frames
  shutdown = 8,         ///< the drive shuts down
  dc_link_high = 9      ///< the link voltage, to which regenerated power is limited
};

/// True for a cause by which the reference ramps to zero.
[[nodiscard]] constexpr bool is_ramp_to_zero(DeratingCause cause) noexcept {
  return cause >= DeratingCause::command_timeout && cause <= DeratingCause::shutdown;
}

}  // namespace sextant
