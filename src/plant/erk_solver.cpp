#include "sextant/plant/erk_solver.hpp"

#include <arkode/arkode_erkstep.h>

#include "small_vector.hpp"
#include "sundials_solution.hpp"

namespace sextant {
namespace {

struct FreeErkStep {
  void operator()(void* memory) const noexcept { ERKStepFree(&memory); }
};

}  // namespace

struct ErkSolver::Implementation : SundialsSolution {
  std::unique_ptr<void, FreeErkStep> memory{};
  bool fresh{true};  // no step since the last restart

  Implementation(const OdeProblem& ode, const ErrorControl& parameters, double relative,
                 std::span<const double> absolute_tolerance);
  void find_events();
  SolverOutcome integrate(const void* plant, double t_end, double* end, int task) noexcept;
};

ErkSolver::Implementation::Implementation(const OdeProblem& ode, const ErrorControl& parameters,
                                          double relative, std::span<const double> absolute_tolerance)
    : SundialsSolution{"ARKODE", ode, relative} {
  allocate(new_runge_kutta_vector, absolute_tolerance);
  memory.reset(ERKStepCreate(derivative, 0.0, x.get(), sundials));
  require(memory != nullptr, "ERKStepCreate");
  require(ERKStepSetErrHandlerFn(memory.get(), discard_message, nullptr) == ARK_SUCCESS,
          "ERKStepSetErrHandlerFn");
  require(ERKStepSetUserData(memory.get(), as_user_data()) == ARK_SUCCESS, "ERKStepSetUserData");
  require(ERKStepSetTableNum(memory.get(), ARKODE_DORMAND_PRINCE_7_4_5) == ARK_SUCCESS, "ERKStepSetTableNum");
  require(ERKStepWFtolerances(memory.get(), weights) == ARK_SUCCESS, "ERKStepWFtolerances");
  if (problem.event_count > 0) find_events();
  prime([this] {
    require(ERKStepEvolve(memory.get(), 1.0, x.get(), &time, ARK_NORMAL) >= ARK_SUCCESS, "ERKStepEvolve");
  });
  require(ERKStepSetMaxNumSteps(memory.get(), parameters.max_steps) == ARK_SUCCESS, "ERKStepSetMaxNumSteps");
}

void ErkSolver::Implementation::find_events() {
  std::vector<int> falling = all_falling();
  require(ERKStepRootInit(memory.get(), problem.event_count, events) == ARK_SUCCESS, "ERKStepRootInit");
  require(ERKStepSetRootDirection(memory.get(), falling.data()) == ARK_SUCCESS, "ERKStepSetRootDirection");
}

SolverOutcome ErkSolver::Implementation::integrate(const void* plant, double t_end, double* end,
                                                   int task) noexcept {
  context = plant;
  // The first guess of a step is the whole segment; the error control shortens it where it must.
  if (fresh && ERKStepSetInitStep(memory.get(), t_end) != ARK_SUCCESS) return SolverOutcome::failed;
  fresh = false;
  if (ERKStepSetStopTime(memory.get(), t_end) != ARK_SUCCESS) return SolverOutcome::failed;
  const int flag = ERKStepEvolve(memory.get(), t_end, x.get(), &time, task);
  return outcome(flag, flag == ARK_ROOT_RETURN ? ERKStepGetRootInfo : nullptr, memory.get(), end);
}

ErkSolver::ErkSolver(const OdeProblem& problem, const ErrorControl& parameters, double relative,
                     std::span<const double> absolute_tolerance)
    : implementation_{std::make_unique<Implementation>(problem, parameters, relative, absolute_tolerance)} {}

ErkSolver::~ErkSolver() = default;

bool ErkSolver::restart(const double* x) noexcept {
  Implementation& self = *implementation_;
  self.set_state(x);
  self.fresh = true;
  return ERKStepReInit(self.memory.get(), Implementation::derivative, 0.0, self.x.get()) == ARK_SUCCESS;
}

ErkSolver::Outcome ErkSolver::advance(const void* context, double t_end, double* x) noexcept {
  return implementation_->integrate(context, t_end, x, ARK_NORMAL);
}

ErkSolver::Outcome ErkSolver::step(const void* context, double t_end, double* x) noexcept {
  return implementation_->integrate(context, t_end, x, ARK_ONE_STEP);
}

double ErkSolver::time() const noexcept {
  return implementation_->time;
}
int ErkSolver::event() const noexcept {
  return implementation_->event;
}

}  // namespace sextant
