#pragma once

#include <memory>
#include <span>

#include "sextant/plant/cvode_parameters.hpp"
#include "sextant/plant/ode_problem.hpp"

namespace sextant {

/// One SUNDIALS CVODE instance. All memory is allocated while constructing.
/// Source: A. C. Hindmarsh et al., "SUNDIALS", ACM Trans. Math. Software 31(3), 2005.
class CvodeSolver {
 public:
  static constexpr const char* name = "CVODE";
  using Parameters = CvodeParameters;
  using Outcome = SolverOutcome;

  /// relative_tolerance [-]; absolute_tolerance: one for each state. Those of the parameters do not count.
  /// Throws std::runtime_error when CVODE cannot be set up.
  CvodeSolver(const OdeProblem& problem, const CvodeParameters& parameters, double relative_tolerance,
              std::span<const double> absolute_tolerance);
  ~CvodeSolver();
  CvodeSolver(const CvodeSolver&) = delete;
  CvodeSolver& operator=(const CvodeSolver&) = delete;

  /// Starts a new solution from x at time zero; false when CVODE refuses.
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
