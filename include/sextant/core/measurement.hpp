#pragma once

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// State of the power stage at the beginning of a control period. The time is an argument of `Drive::step`.
template <class T = double>
struct Measurement {
  ThreePhase<T> i_abc{};  ///< phase currents, positive into the machine [A]
  T u_dc{};               ///< DC-link voltage [V]
  T omega_m{};            ///< mechanical speed [rad/s]
  GatePattern applied{};  ///< applied pattern: gate states over the time since the last measurement
  bool plausible{true};   ///< false: the power stage, or its simulation, has no valid measurement
};

}  // namespace sextant
