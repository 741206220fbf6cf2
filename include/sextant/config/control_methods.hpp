#pragma once

#include <tuple>

#include "sextant/config/control_method.hpp"
#include "sextant/config/direct_torque_config.hpp"
#include "sextant/config/flux_vector_config.hpp"
#include "sextant/config/modulated_config.hpp"

namespace sextant {

/// Every control method of Sextant, the default first. The configuration, the real-time safety check and the
/// conformance test walk this list.
template <class T>
using ControllerList = std::tuple<DirectTorqueController<T>, DutyRatioController<T>, PredictiveController<T>,
                                  PwmDtcController<T>, FeedbackLinearisationController<T>,
                                  FieldOrientedController<T>, DeadbeatController<T>>;

/// Their descriptions for the configuration.
[[nodiscard]] ControlMethods control_methods();

}  // namespace sextant
