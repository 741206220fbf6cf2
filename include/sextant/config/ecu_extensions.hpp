#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/own_power_stage.hpp"

namespace sextant {

/// What a program brings beside Sextant's own, for the configuration of a live drive to choose by name.
struct EcuExtensions {
  ControlMethods methods{};       ///< `control.controller`
  OwnPowerStages power_stages{};  ///< `power_stage`
};

}  // namespace sextant
