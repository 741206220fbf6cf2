#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "ecu/parameters/parameter_changes.hpp"
#include "sextant/config/drives_config.hpp"

namespace sextant::ecu {

/// The drives' configuration with further overrides; throws ConfigError.
using LoadDrives = std::function<DrivesConfig(const std::vector<std::string>& more)>;

/// The same for one of the drives, with overrides for this drive alone. Throws std::runtime_error with one
/// sentence where the file has other drives meanwhile, and for a key of the process. running: with which they
/// run; must outlive the result.
[[nodiscard]] ParameterChanges::Load load_of(LoadDrives load, std::size_t drive, const DrivesConfig& running);

}  // namespace sextant::ecu
