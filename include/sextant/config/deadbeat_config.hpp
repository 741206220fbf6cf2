#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/deadbeat_controller.hpp"

namespace sextant {

/// The table [control.deadbeat].
void describe(Section table, DeadbeatController<>::Parameters& parameters, const ControlSetup& setup);

/// The estimate meets its reference at the end of every period.
[[nodiscard]] bool trims_mean_torque(const DeadbeatController<>::Parameters& parameters);

}  // namespace sextant
