#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {

/// The table [control.foc].
void describe(Section table, FieldOrientedController<>::Parameters& parameters, const ControlSetup& setup);

/// The current controller integrates, and the torque of the estimate is that of flux and current.
[[nodiscard]] bool trims_mean_torque(const FieldOrientedController<>::Parameters& parameters);

}  // namespace sextant
