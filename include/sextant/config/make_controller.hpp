#pragma once

#include <memory>

#include "sextant/config/drive_config.hpp"
#include "sextant/control/controller.hpp"

namespace sextant {

/// The controller selected by the configuration.
[[nodiscard]] inline std::unique_ptr<Controller<double>> make_controller(const DriveConfig& config) {
  switch (config.controller) {
    case ControllerKind::direct_torque:
      break;
  }
  return std::make_unique<DirectTorqueController<double>>(config.direct_torque);
}

}  // namespace sextant
