#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/magnetiser.hpp"
#include "sextant/control/torque_trim.hpp"

namespace sextant {

/// The keys of magnetising in the table of a control method.
void describe_magnetiser(Section table, Magnetiser<>::Parameters& parameters, const ControlSetup& setup);

/// The key of the trim of the mean torque.
void describe_torque_trim(Section table, TorqueTrim<>::Parameters& parameters);

}  // namespace sextant
