#pragma once

#include <optional>
#include <type_traits>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// State of the power stage at the beginning of a control period. The time is an argument of `Drive::step`.
template <class T = double>
struct Measurement {
  ThreePhase<T> i_abc{};  ///< phase currents, positive into the machine [A]
  T u_dc{};               ///< DC-link voltage [V]
  T omega_m{};            ///< mechanical speed [rad/s]
  GatePattern applied{};  ///< applied pattern: commanded states over the time since the last measurement
  bool plausible{true};   ///< false: the power stage, or its simulation, has no valid measurement
  /// Mechanical angle of the rotor from its position at power-up, in [−π, π]; empty without such a sensor
  /// [rad]
  std::optional<T> theta_m{};
  std::optional<T> winding_temperature{};  ///< of the stator; empty without such a sensor [°C]
};

static_assert(std::is_trivially_copyable_v<Measurement<double>>);

}  // namespace sextant
