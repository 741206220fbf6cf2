#pragma once

#include "sextant/plant/erk_solver.hpp"
#include "sextant/plant/variable_step_integrator.hpp"

namespace sextant {

/// SUNDIALS ARKODE, ERKStep: an explicit Runge-Kutta pair of order 5 and 4 with error control. Between the
/// fixed step, which it resembles, and CVODE, whose tolerances it has.
template <class Plant>
class ErkIntegrator final : public VariableStepIntegrator<Plant, ErkSolver> {
 public:
  using VariableStepIntegrator<Plant, ErkSolver>::VariableStepIntegrator;
};

}  // namespace sextant
