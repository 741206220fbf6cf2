#pragma once

#include <cstdint>

namespace sextant {

/// For what the torque reference has to be zero whatever the command asks.
enum class ZeroRequest : std::uint8_t {
  none,
  awaits_flux,  ///< there is no torque before there is flux
  shutdown      ///< the drive winds down
};

}  // namespace sextant
