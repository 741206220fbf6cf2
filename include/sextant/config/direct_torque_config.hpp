#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/direct_torque_controller.hpp"

namespace sextant {

/// The table [control.dtc].
void describe(Section table, DirectTorqueController<>::Parameters& parameters, const ControlSetup& setup);

}  // namespace sextant
