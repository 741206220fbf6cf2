#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/control/controller_list.hpp"

namespace sextant {

/// Descriptions of `ControllerList` and `CommissioningList` for the configuration, the default first.
[[nodiscard]] ControlMethods control_methods();

}  // namespace sextant
