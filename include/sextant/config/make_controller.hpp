#pragma once

#include <memory>

#include "sextant/config/drive_config.hpp"
#include "sextant/control/controller.hpp"

namespace sextant {

/// The controller selected by the configuration.
[[nodiscard]] inline std::unique_ptr<Controller<double>> make_controller(const DriveConfig& config) {
  return config.method().make();
}

}  // namespace sextant
