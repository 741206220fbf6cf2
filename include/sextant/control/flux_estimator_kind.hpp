#pragma once

#include <cstdint>

namespace sextant {

/// Method by which a controller estimates the stator flux while the gates are driven.
enum class FluxEstimatorKind : std::uint8_t {
  voltage_model,              ///< open integrator of u_s − R_s i_s: the paper's
  compensated_voltage_model,  ///< voltage model by a low-pass filter with correction of its gain and phase
  current_model,              ///< rotor flux from current and speed
  hybrid,                     ///< voltage model at speed, current model near standstill
  observer,                   ///< full-order observer with measured speed
  sensorless_observer         ///< full-order observer that estimates the speed
};

}  // namespace sextant
