#pragma once

#include <string>
#include <vector>

#include "config/config_files.hpp"

namespace sextant {

/// The sentence that refuses a file of sextant-plant; "accepted" without one.
inline std::string plant_refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_plant_config(shipped_plant, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

/// What sextant-ecu, a scenario and sextant-plant say of settings of the plant that each of them has.
inline std::vector<std::string> refusals_of_each(const std::vector<std::string>& overrides) {
  return {ecu_refusal(shipped_ecu, overrides), scenario_refusal(overrides), plant_refusal(overrides)};
}

}  // namespace sextant
