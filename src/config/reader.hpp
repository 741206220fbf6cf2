#pragma once

#include <vector>

#include "layer.hpp"
#include "sextant/config/schema.hpp"

namespace sextant {

/// Sets every member whose key is in a layer, runs the derivations and the checks. Throws ConfigError with
/// all problems found; the members are then in an unspecified state.
void read(const Schema& schema, const std::vector<Layer>& layers);

}  // namespace sextant
