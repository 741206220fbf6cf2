#pragma once

#include <tuple>

#include "sextant/control/commissioning_controller.hpp"
#include "sextant/control/deadbeat_controller.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/control/duty_ratio_controller.hpp"
#include "sextant/control/feedback_linearisation_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"
#include "sextant/control/predictive_controller.hpp"
#include "sextant/control/pwm_dtc_controller.hpp"

namespace sextant {

/// Every control method of Sextant that follows a torque reference, the paper's first. The configuration, the
/// bench, the firmware's count of instructions, the real-time safety check and the conformance test walk this
/// list.
template <class T>
using ControllerList = std::tuple<DirectTorqueController<T>, DutyRatioController<T>, PredictiveController<T>,
                                  PwmDtcController<T>, FeedbackLinearisationController<T>,
                                  FieldOrientedController<T>, DeadbeatController<T>>;

/// Those that measure machine and inverter instead, and make no torque. The configuration, the real-time
/// safety check and the conformance test walk this list too; nothing that compares torque does.
template <class T>
using CommissioningList = std::tuple<CommissioningController<T>>;

}  // namespace sextant
