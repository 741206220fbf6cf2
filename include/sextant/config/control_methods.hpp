#pragma once

#include "sextant/config/commissioning_config.hpp"
#include "sextant/config/control_method.hpp"
#include "sextant/config/direct_torque_config.hpp"
#include "sextant/config/flux_vector_config.hpp"
#include "sextant/config/modulated_config.hpp"
#include "sextant/control/controller_list.hpp"

namespace sextant {

/// Descriptions of `ControllerList` and `CommissioningList` for the configuration, the default first.
[[nodiscard]] ControlMethods control_methods();

}  // namespace sextant
