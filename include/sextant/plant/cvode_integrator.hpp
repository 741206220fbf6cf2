#pragma once

#include "sextant/plant/cvode_solver.hpp"
#include "sextant/plant/variable_step_integrator.hpp"

namespace sextant {

/// SUNDIALS CVODE: linear multistep methods of variable step and order.
template <class Plant>
class CvodeIntegrator final : public VariableStepIntegrator<Plant, CvodeSolver> {
 public:
  using VariableStepIntegrator<Plant, CvodeSolver>::VariableStepIntegrator;
};

}  // namespace sextant
