#pragma once

#include <tuple>

#include "sextant/config/control_method.hpp"
#include "sextant/config/deadbeat_config.hpp"
#include "sextant/config/direct_torque_config.hpp"
#include "sextant/config/field_oriented_config.hpp"
#include "sextant/control/deadbeat_controller.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {

/// Every control method of Sextant, the default first. The configuration, the real-time safety check and the
/// conformance test walk this list.
template <class T>
using ControllerList =
    std::tuple<DirectTorqueController<T>, DeadbeatController<T>, FieldOrientedController<T>>;

/// Their descriptions for the configuration.
[[nodiscard]] ControlMethods control_methods();

}  // namespace sextant
