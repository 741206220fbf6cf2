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

inline void describe(Description& d, CvodeParameters& p) {
  d.choice("method", p.method, {{"adams", CvodeMethod::adams_fixed_point}, {"bdf", CvodeMethod::bdf_newton}},
           "Adams with fixed-point iteration, or BDF with Newton's");
  describe(d, static_cast<ErrorControl&>(p));
}

}  // namespace sextant
