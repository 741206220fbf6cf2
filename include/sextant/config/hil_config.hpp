#pragma once

#include "sextant/config/schema.hpp"
#include "sextant/hil/hil_parameters.hpp"

namespace sextant {

/// The table [hil], the same on both sides of a link.
void describe(Section section, HilParameters& parameters);

}  // namespace sextant
