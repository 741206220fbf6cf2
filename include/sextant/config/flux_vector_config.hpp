#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/predictive_controller.hpp"

namespace sextant {

/// The tables [control.predictive] and [control.duty_ratio].
void describe(Section table, FluxVectorController<>::Parameters& parameters, const ControlSetup& setup);

/// Without their trim the mean torque is below its reference by what the patterns of the set leave.
[[nodiscard]] bool trims_mean_torque(const FluxVectorController<>::Parameters& parameters);

}  // namespace sextant
