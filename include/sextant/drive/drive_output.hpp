#pragma once

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

/// Output of one control period.
template <class T = double>
struct DriveOutput {
  GatePattern pattern{};
  Telemetry<T> telemetry{};
};

}  // namespace sextant
