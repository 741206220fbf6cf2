#pragma once

#include <memory>
#include <span>

#include "sextant/plant/error_control.hpp"
#include "sextant/plant/ode_problem.hpp"

namespace sextant {

/// One instance of ERKStep of SUNDIALS ARKODE: the explicit Runge-Kutta pair of order 5 and 4 of Dormand and
/// Prince with error control. A one-step method has no history to lose at a switching edge: its first step
/// is already as long as its accuracy allows. All memory is allocated while constructing.
/// Source: J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6, 1980; D. R. Reynolds et al., "ARKODE", ACM
/// Trans. Math. Software 49(2), 2023.
class ErkSolver {
 public:
  static constexpr const char* name = "ERK";
  using Parameters = ErrorControl;
  using Outcome = SolverOutcome;

  /// relative_tolerance [-]; absolute_tolerance: one for each state. Those of the parameters do not count.
  /// Throws std::runtime_error when ARKODE cannot be set up.
  ErkSolver(const OdeProblem& problem, const ErrorControl& parameters, double relative_tolerance,
            std::span<const double> absolute_tolerance);
  ~ErkSolver();
  ErkSolver(const ErkSolver&) = delete;
  ErkSolver& operator=(const ErkSolver&) = delete;

  /// Starts a new solution from x at time zero; false when ARKODE refuses.
  [[nodiscard]] bool restart(const double* x) noexcept;

  /// Integrates to t_end [s], counted from the last restart, or to the first event. On success x is the state
  /// there. After `failed` the solver must be restarted.
  [[nodiscard]] Outcome advance(const void* context, double t_end, double* x) noexcept;

  /// The same by one internal step, which ends at t_end at the latest; `time` tells where it has ended. The
  /// problem must have no events.
  [[nodiscard]] Outcome step(const void* context, double t_end, double* x) noexcept;

  /// Time since the last restart. [s]
  [[nodiscard]] double time() const noexcept;
  /// The lowest event function whose event stopped the last advance. [-]
  [[nodiscard]] int event() const noexcept;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sextant
