#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/predictive_controller.hpp"

namespace sextant {

/// The tables [control.predictive] and [control.duty_ratio].
void describe(Section table, FluxVectorController<>::Parameters& parameters, const ControlSetup& setup);

/// False: a mean torque may miss its reference by what a pattern of the set can.
[[nodiscard]] bool trims_mean_torque(const FluxVectorController<>::Parameters& parameters);

}  // namespace sextant
