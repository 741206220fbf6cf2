#include "sextant/plant/cvode_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <cvode/cvode.h>
#include <sundials/sundials_context.hpp>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "small_vector.hpp"

namespace sextant {
namespace {

struct FreeVector {
  void operator()(N_Vector v) const noexcept { N_VDestroy(v); }
};
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
template <class Handle, class Free>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;

constexpr int unrecoverable = -1;

void require(bool good, const char* call) {
  if (!good) throw std::runtime_error(std::string("CVODE cannot be set up: ") + call + " failed");
}

// Failures are reported by return values; SUNDIALS' own messages would go to stderr from the control thread.
void discard_message(int, const char*, const char*, char*, void*) {}

}  // namespace

struct CvodeSolver::Implementation {
  OdeProblem problem;
  const void* context{nullptr};
  sundials::Context sundials{};
  Owned<N_Vector, FreeVector> x;
  Owned<N_Vector, FreeVector> tolerance;
  Owned<SUNMatrix, FreeMatrix> matrix;
  Owned<SUNLinearSolver, FreeLinearSolver> linear_solver;
  Owned<SUNNonlinearSolver, FreeNonlinearSolver> nonlinear_solver;
  std::unique_ptr<void, FreeCvode> memory;
  std::vector<int> fired;  // event functions that stopped the last advance
  double time{};           // since the last restart [s]
  int event{};

  static int derivative(sunrealtype, N_Vector x, N_Vector dx, void* user) {
    const auto& self = *static_cast<const Implementation*>(user);
    double* const slope = N_VGetArrayPointer(dx);
    self.problem.derivative(self.context, N_VGetArrayPointer(x), slope);
    // CVODE's norms compare false with NaN, so that it would take one for a small error.
    double sum = 0.0;
    for (int i = 0; i < self.problem.size; ++i) sum += slope[i];
    return std::isfinite(sum) ? 0 : unrecoverable;
  }

  static int jacobian(sunrealtype, N_Vector x, N_Vector, SUNMatrix j, void* user, N_Vector, N_Vector,
                      N_Vector) {
    const auto& self = *static_cast<const Implementation*>(user);
    self.problem.jacobian(self.context, N_VGetArrayPointer(x), SUNDenseMatrix_Data(j));
    return 0;
  }

  static int events(sunrealtype, N_Vector x, sunrealtype* g, void* user) {
    const auto& self = *static_cast<const Implementation*>(user);
    self.problem.events(self.context, N_VGetArrayPointer(x), g);
    return 0;
  }

  void create(const CvodeParameters& parameters, std::span<const double> absolute_tolerance);
  void attach_method(const CvodeParameters& parameters);
  void prime();
};

void CvodeSolver::Implementation::create(const CvodeParameters& parameters,
                                         std::span<const double> absolute_tolerance) {
  const bool adams = parameters.method == CvodeMethod::adams_fixed_point;
  x.reset(new_small_vector(problem.size, sundials));
  tolerance.reset(new_small_vector(problem.size, sundials));
  require(x && tolerance, "N_VNew_Serial");
  N_VConst(0.0, x.get());
  std::copy(absolute_tolerance.begin(), absolute_tolerance.end(), N_VGetArrayPointer(tolerance.get()));

  memory.reset(CVodeCreate(adams ? CV_ADAMS : CV_BDF, sundials));
  require(memory != nullptr, "CVodeCreate");
  require(CVodeSetErrHandlerFn(memory.get(), discard_message, nullptr) == CV_SUCCESS, "CVodeSetErrHandlerFn");
  require(CVodeInit(memory.get(), derivative, 0.0, x.get()) == CV_SUCCESS, "CVodeInit");
  require(CVodeSetUserData(memory.get(), this) == CV_SUCCESS, "CVodeSetUserData");
  require(CVodeSVtolerances(memory.get(), parameters.relative_tolerance, tolerance.get()) == CV_SUCCESS,
          "CVodeSVtolerances");
  attach_method(parameters);
  if (problem.event_count > 0) {
    fired.assign(static_cast<std::size_t>(problem.event_count), 0);
    std::vector<int> falling(static_cast<std::size_t>(problem.event_count), -1);
    require(CVodeRootInit(memory.get(), problem.event_count, events) == CV_SUCCESS, "CVodeRootInit");
    require(CVodeSetRootDirection(memory.get(), falling.data()) == CV_SUCCESS, "CVodeSetRootDirection");
  }
  prime();
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

// SUNDIALS allocates in the first call of CVode; a harmless problem, dx/dt = 1 − x, makes it do so now.
void CvodeSolver::Implementation::prime() {
  const OdeProblem real = problem;
  problem.derivative = [](const void* self, const double* state, double* slope) noexcept {
    for (int i = 0; i < static_cast<const OdeProblem*>(self)->size; ++i) slope[i] = 1.0 - state[i];
  };
  problem.jacobian = [](const void* self, const double*, double* j) noexcept {
    const int n = static_cast<const OdeProblem*>(self)->size;
    for (int i = 0; i < n * n; ++i) j[i] = i % (n + 1) == 0 ? -1.0 : 0.0;
  };
  problem.events = [](const void* self, const double* state, double* g) noexcept {
    std::fill_n(g, static_cast<const OdeProblem*>(self)->event_count, 0.5 - *state);
  };
  context = &real;
  const int flag = CVode(memory.get(), 1.0, x.get(), &time, CV_NORMAL);
  require(flag >= CV_SUCCESS, "CVode");
  problem = real;
}

CvodeSolver::CvodeSolver(const OdeProblem& problem, const CvodeParameters& parameters,
                         std::span<const double> absolute_tolerance)
    : implementation_{std::make_unique<Implementation>()} {
  implementation_->problem = problem;
  implementation_->create(parameters, absolute_tolerance);
}

CvodeSolver::~CvodeSolver() = default;

bool CvodeSolver::restart(const double* x) noexcept {
  Implementation& self = *implementation_;
  std::copy_n(x, self.problem.size, N_VGetArrayPointer(self.x.get()));
  self.time = 0.0;
  return CVodeReInit(self.memory.get(), 0.0, self.x.get()) == CV_SUCCESS;
}

CvodeSolver::Outcome CvodeSolver::advance(const void* context, double t_end, double* x) noexcept {
  Implementation& self = *implementation_;
  self.context = context;
  if (CVodeSetStopTime(self.memory.get(), t_end) != CV_SUCCESS) return Outcome::failed;
  const int flag = CVode(self.memory.get(), t_end, self.x.get(), &self.time, CV_NORMAL);
  if (flag < 0) return Outcome::failed;
  const double* const state = N_VGetArrayPointer(self.x.get());
  for (int i = 0; i < self.problem.size; ++i) {
    if (!std::isfinite(state[i])) return Outcome::failed;
  }
  std::copy_n(state, self.problem.size, x);
  if (flag != CV_ROOT_RETURN) return Outcome::reached;
  if (CVodeGetRootInfo(self.memory.get(), self.fired.data()) != CV_SUCCESS) return Outcome::failed;
  const auto first = std::find_if(self.fired.begin(), self.fired.end(), [](int f) { return f != 0; });
  self.event = int(first - self.fired.begin());
  return first == self.fired.end() ? Outcome::failed : Outcome::event;
}

double CvodeSolver::time() const noexcept {
  return implementation_->time;
}
int CvodeSolver::event() const noexcept {
  return implementation_->event;
}

}  // namespace sextant
