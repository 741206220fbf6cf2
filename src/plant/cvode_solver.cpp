#include "sextant/plant/cvode_solver.hpp"

#include <cvode/cvode.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "small_vector.hpp"
#include "sundials_solution.hpp"

namespace sextant {
namespace {

struct FreeMatrix {
  void operator()(SUNMatrix m) const noexcept { SUNMatDestroy(m); }
};
struct FreeLinearSolver {
  void operator()(SUNLinearSolver s) const noexcept { SUNLinSolFree(s); }
};
struct FreeNonlinearSolver {
  void operator()(SUNNonlinearSolver s) const noexcept { SUNNonlinSolFree(s); }
};
struct FreeCvode {
  void operator()(void* memory) const noexcept { CVodeFree(&memory); }
};

}  // namespace

struct CvodeSolver::Implementation : SundialsSolution {
  Owned<SUNMatrix, FreeMatrix> matrix{};
  Owned<SUNLinearSolver, FreeLinearSolver> linear_solver{};
  Owned<SUNNonlinearSolver, FreeNonlinearSolver> nonlinear_solver{};
  std::unique_ptr<void, FreeCvode> memory{};

  Implementation(const OdeProblem& ode, const CvodeParameters& parameters, double relative,
                 std::span<const double> absolute_tolerance);
  void attach_method(const CvodeParameters& parameters);
  void find_events();
  SolverOutcome integrate(const void* plant, double t_end, double* end, int task) noexcept;

  static int jacobian(sunrealtype t, N_Vector x, N_Vector, SUNMatrix j, void* user, N_Vector, N_Vector,
                      N_Vector) {
    const auto& self = *static_cast<const SundialsSolution*>(user);
    self.problem.jacobian(self.context, t, N_VGetArrayPointer(x), SUNDenseMatrix_Data(j));
    return 0;
  }
};

CvodeSolver::Implementation::Implementation(const OdeProblem& ode, const CvodeParameters& parameters,
                                            double relative, std::span<const double> absolute_tolerance)
    : SundialsSolution{"CVODE", ode, relative} {
  allocate(new_small_vector, absolute_tolerance);
  memory.reset(
      CVodeCreate(parameters.method == CvodeMethod::adams_fixed_point ? CV_ADAMS : CV_BDF, sundials));
  require(memory != nullptr, "CVodeCreate");
  require(CVodeSetErrHandlerFn(memory.get(), discard_message, nullptr) == CV_SUCCESS, "CVodeSetErrHandlerFn");
  require(CVodeInit(memory.get(), derivative, 0.0, x.get()) == CV_SUCCESS, "CVodeInit");
  require(CVodeSetUserData(memory.get(), as_user_data()) == CV_SUCCESS, "CVodeSetUserData");
  require(CVodeWFtolerances(memory.get(), weights) == CV_SUCCESS, "CVodeWFtolerances");
  attach_method(parameters);
  if (problem.event_count > 0) find_events();
  prime([this] { require(CVode(memory.get(), 1.0, x.get(), &time, CV_NORMAL) >= CV_SUCCESS, "CVode"); });
  require(CVodeSetMaxNumSteps(memory.get(), parameters.max_steps) == CV_SUCCESS, "CVodeSetMaxNumSteps");
}

void CvodeSolver::Implementation::attach_method(const CvodeParameters& parameters) {
  if (parameters.method == CvodeMethod::adams_fixed_point) {
    nonlinear_solver.reset(SUNNonlinSol_FixedPoint(x.get(), 0, sundials));
    require(nonlinear_solver != nullptr, "SUNNonlinSol_FixedPoint");
    require(CVodeSetNonlinearSolver(memory.get(), nonlinear_solver.get()) == CV_SUCCESS,
            "CVodeSetNonlinearSolver");
    return;
  }
  matrix.reset(SUNDenseMatrix(problem.size, problem.size, sundials));
  require(matrix != nullptr, "SUNDenseMatrix");
  linear_solver.reset(SUNLinSol_Dense(x.get(), matrix.get(), sundials));
  require(linear_solver != nullptr, "SUNLinSol_Dense");
  require(CVodeSetLinearSolver(memory.get(), linear_solver.get(), matrix.get()) == CV_SUCCESS,
          "CVodeSetLinearSolver");
  require(CVodeSetJacFn(memory.get(), jacobian) == CV_SUCCESS, "CVodeSetJacFn");
}

void CvodeSolver::Implementation::find_events() {
  std::vector<int> falling = all_falling();
  require(CVodeRootInit(memory.get(), problem.event_count, events) == CV_SUCCESS, "CVodeRootInit");
  require(CVodeSetRootDirection(memory.get(), falling.data()) == CV_SUCCESS, "CVodeSetRootDirection");
}

SolverOutcome CvodeSolver::Implementation::integrate(const void* plant, double t_end, double* end,
                                                     int task) noexcept {
  context = plant;
  if (CVodeSetStopTime(memory.get(), t_end) != CV_SUCCESS) return SolverOutcome::failed;
  const int flag = CVode(memory.get(), t_end, x.get(), &time, task);
  return outcome(flag, flag == CV_ROOT_RETURN ? CVodeGetRootInfo : nullptr, memory.get(), end);
}

CvodeSolver::CvodeSolver(const OdeProblem& problem, const CvodeParameters& parameters, double relative,
                         std::span<const double> absolute_tolerance)
    : implementation_{std::make_unique<Implementation>(problem, parameters, relative, absolute_tolerance)} {}

CvodeSolver::~CvodeSolver() = default;

bool CvodeSolver::restart(const double* x) noexcept {
  Implementation& self = *implementation_;
  self.set_state(x);
  return CVodeReInit(self.memory.get(), 0.0, self.x.get()) == CV_SUCCESS;
}

CvodeSolver::Outcome CvodeSolver::advance(const void* context, double t_end, double* x) noexcept {
  return implementation_->integrate(context, t_end, x, CV_NORMAL);
}

CvodeSolver::Outcome CvodeSolver::step(const void* context, double t_end, double* x) noexcept {
  return implementation_->integrate(context, t_end, x, CV_ONE_STEP);
}

double CvodeSolver::time() const noexcept {
  return implementation_->time;
}
int CvodeSolver::event() const noexcept {
  return implementation_->event;
}

}  // namespace sextant
