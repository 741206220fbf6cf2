#pragma once

#include <nlohmann/json.hpp>

#include "sextant/plant/cvode_parameters.hpp"

namespace sextant::bench {

/// CVODE at that relative tolerance, with absolute ones that do not limit it.
[[nodiscard]] CvodeParameters cvode_at(double tolerance, CvodeMethod method = CvodeMethod::adams_fixed_point);

/// The integrators as shipped under the closed loops of `dtc` and `foc`: times real time and the torque's
/// error. See scripts/work_precision.
[[nodiscard]] nlohmann::json closed_loops();

}  // namespace sextant::bench
