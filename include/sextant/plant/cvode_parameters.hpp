#pragma once

#include <cstdint>

#include "sextant/plant/error_control.hpp"

namespace sextant {

/// Linear multistep method and the iteration that solves its implicit equation.
enum class CvodeMethod : std::uint8_t {
  adams_fixed_point,  ///< Adams-Moulton, fixed-point iteration: for non-stiff plants, the fastest
  bdf_newton          ///< backward differentiation, Newton with the analytic Jacobian: for stiff plants
};

/// Accuracy and method of CVODE.
struct CvodeParameters : ErrorControl {
  CvodeMethod method{CvodeMethod::adams_fixed_point};
};

}  // namespace sextant
