#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/commissioning_controller.hpp"

namespace sextant {

/// The table [control.commissioning].
void describe(Section table, CommissioningController<>::Parameters& parameters, const ControlSetup& setup);

}  // namespace sextant
