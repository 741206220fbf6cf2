#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/predictive_controller.hpp"

namespace sextant {

/// The table [control.duty_ratio].
void describe(Section table, FluxVectorController<>::Parameters& parameters, const ControlSetup& setup);
/// The table [control.predictive]: with vectors that act for whole periods the time constant of its trim
/// follows from what they change.
void describe(Section table, PredictiveController<>::Parameters& parameters, const ControlSetup& setup);

}  // namespace sextant
