#pragma once

#include "sextant/config/drive_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/sim/scenario.hpp"

namespace sextant {

/// A run of the simulated drive, as one file describes it.
struct ScenarioConfig {
  Scenario scenario{};  ///< its load is made of drive.load
  DriveConfig drive{};
};

void describe(Section root, ScenarioConfig& config);

}  // namespace sextant
