#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/deadbeat_controller.hpp"
#include "sextant/control/feedback_linearisation_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"
#include "sextant/control/pwm_dtc_controller.hpp"

namespace sextant {

/// The tables [control.deadbeat], [control.foc], [control.feedback_linearisation] and [control.pwm_dtc].
void describe(Section table, DeadbeatController<>::Parameters& parameters, const ControlSetup& setup);
void describe(Section table, FieldOrientedController<>::Parameters& parameters, const ControlSetup& setup);
void describe(Section table, FeedbackLinearisationController<>::Parameters& parameters,
              const ControlSetup& setup);
void describe(Section table, PwmDtcController<>::Parameters& parameters, const ControlSetup& setup);

}  // namespace sextant
