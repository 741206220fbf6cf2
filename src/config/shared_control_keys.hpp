#pragma once

#include "sextant/config/control_method.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/magnetiser.hpp"
#include "sextant/control/torque_trim.hpp"

namespace sextant {

/// The keys of magnetising in the table of a control method.
void describe_magnetiser(Section table, Magnetiser<>::Parameters& parameters, const ControlSetup& setup);

/// The key of the trim of the mean torque, for a method whose trim has the same time constant with every
/// machine, and for one where it follows from flux reference, link and period.
void describe_torque_trim(Section table, TorqueTrim<>::Parameters& parameters);
void describe_torque_trim(Section table, TorqueTrim<>::Parameters& parameters, const ControlSetup& setup);

}  // namespace sextant
