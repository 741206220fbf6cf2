#pragma once

#include <cstdint>

namespace sextant {

/// What an integrator does where the inverter switches between two states with every leg driven.
enum class AtSwitching : std::uint8_t {
  by_tolerance,  ///< goes on unless the relative tolerance is tighter than 1e-7; of a variable step
  go_on,         ///< goes on over the switching within a control period
  stop           ///< ends a step there, and restarts a method that has a history
};

}  // namespace sextant
