#pragma once

#include <string>

#include "sextant/config/ecu_config.hpp"

namespace sextant::ecu {

/// What of a drive its CAN contract cannot carry: a sentence that names each signal, its range and the value
/// of the drive beyond it; empty where everything fits.
[[nodiscard]] std::string beyond_contract(const DriveConfig& config);

}  // namespace sextant::ecu
