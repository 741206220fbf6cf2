#pragma once

#include "sextant/config/schema.hpp"
#include "sextant/plant/inverter_loss_parameters.hpp"

namespace sextant {

/// The keys of `[plant.inverter.losses]`.
void describe(Section s, InverterLossParameters& parameters);

}  // namespace sextant
