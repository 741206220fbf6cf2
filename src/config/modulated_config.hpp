#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// The keys that all control methods with a space-vector modulator share.
void describe_modulated(Section table, ModulatedController<>::Parameters& parameters,
                        const ControlSetup& setup);

}  // namespace sextant
