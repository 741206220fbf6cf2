#include "sextant/plant/erk_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <arkode/arkode_erkstep.h>
#include <sundials/sundials_context.hpp>

#include "small_vector.hpp"

namespace sextant {
namespace {

struct FreeVector {
  void operator()(N_Vector v) const noexcept { N_VDestroy(v); }
};
struct FreeErkStep {
  void operator()(void* memory) const noexcept { ERKStepFree(&memory); }
};
using OwnedVector = std::unique_ptr<std::remove_pointer_t<N_Vector>, FreeVector>;

constexpr int unrecoverable = -1;

void require(bool good, const char* call) {
  if (!good) throw std::runtime_error(std::string("ARKODE cannot be set up: ") + call + " failed");
}

// Failures are reported by return values; SUNDIALS' own messages would go to stderr from the control thread.
void discard_message(int, const char*, const char*, char*, void*) {}

}  // namespace

struct ErkSolver::Implementation {
  OdeProblem problem;
  const void* context{nullptr};
  sundials::Context sundials{};
  OwnedVector x;
  OwnedVector tolerance;
  std::unique_ptr<void, FreeErkStep> memory;
  std::vector<int> fired;  // event functions that stopped the last advance
  double time{};           // since the last restart [s]
  bool fresh{true};        // no step since the last restart
  int event{};

  static int derivative(sunrealtype, N_Vector x, N_Vector dx, void* user) {
    const auto& self = *static_cast<const Implementation*>(user);
    double* const slope = N_VGetArrayPointer(dx);
    self.problem.derivative(self.context, N_VGetArrayPointer(x), slope);
    // ARKODE's norms compare false with NaN, so that it would take one for a small error.
    double sum = 0.0;
    for (int i = 0; i < self.problem.size; ++i) sum += slope[i];
    return std::isfinite(sum) ? 0 : unrecoverable;
  }

  static int events(sunrealtype, N_Vector x, sunrealtype* g, void* user) {
    const auto& self = *static_cast<const Implementation*>(user);
    self.problem.events(self.context, N_VGetArrayPointer(x), g);
    return 0;
  }

  void create(const ErrorControl& parameters, std::span<const double> absolute_tolerance);
  void prime();
};

void ErkSolver::Implementation::create(const ErrorControl& parameters,
                                       std::span<const double> absolute_tolerance) {
  x.reset(new_runge_kutta_vector(problem.size, sundials));
  tolerance.reset(new_runge_kutta_vector(problem.size, sundials));
  require(x && tolerance, "N_VNew_Serial");
  N_VConst(0.0, x.get());
  std::copy(absolute_tolerance.begin(), absolute_tolerance.end(), N_VGetArrayPointer(tolerance.get()));

  memory.reset(ERKStepCreate(derivative, 0.0, x.get(), sundials));
  require(memory != nullptr, "ERKStepCreate");
  require(ERKStepSetErrHandlerFn(memory.get(), discard_message, nullptr) == ARK_SUCCESS,
          "ERKStepSetErrHandlerFn");
  require(ERKStepSetUserData(memory.get(), this) == ARK_SUCCESS, "ERKStepSetUserData");
  require(ERKStepSetTableNum(memory.get(), ARKODE_DORMAND_PRINCE_7_4_5) == ARK_SUCCESS, "ERKStepSetTableNum");
  require(ERKStepSVtolerances(memory.get(), parameters.relative_tolerance, tolerance.get()) == ARK_SUCCESS,
          "ERKStepSVtolerances");
  if (problem.event_count > 0) {
    fired.assign(static_cast<std::size_t>(problem.event_count), 0);
    std::vector<int> falling(static_cast<std::size_t>(problem.event_count), -1);
    require(ERKStepRootInit(memory.get(), problem.event_count, events) == ARK_SUCCESS, "ERKStepRootInit");
    require(ERKStepSetRootDirection(memory.get(), falling.data()) == ARK_SUCCESS, "ERKStepSetRootDirection");
  }
  prime();
  require(ERKStepSetMaxNumSteps(memory.get(), parameters.max_steps) == ARK_SUCCESS, "ERKStepSetMaxNumSteps");
}

// ARKODE allocates in its first step; a harmless problem, dx/dt = 1 − x, makes it do so now.
void ErkSolver::Implementation::prime() {
  const OdeProblem real = problem;
  problem.derivative = [](const void* self, const double* state, double* slope) noexcept {
    for (int i = 0; i < static_cast<const OdeProblem*>(self)->size; ++i) slope[i] = 1.0 - state[i];
  };
  problem.events = [](const void* self, const double* state, double* g) noexcept {
    std::fill_n(g, static_cast<const OdeProblem*>(self)->event_count, 0.5 - *state);
  };
  context = &real;
  const int flag = ERKStepEvolve(memory.get(), 1.0, x.get(), &time, ARK_NORMAL);
  require(flag >= ARK_SUCCESS, "ERKStepEvolve");
  problem = real;
}

ErkSolver::ErkSolver(const OdeProblem& problem, const ErrorControl& parameters,
                     std::span<const double> absolute_tolerance)
    : implementation_{std::make_unique<Implementation>()} {
  implementation_->problem = problem;
  implementation_->create(parameters, absolute_tolerance);
}

ErkSolver::~ErkSolver() = default;

bool ErkSolver::restart(const double* x) noexcept {
  Implementation& self = *implementation_;
  std::copy_n(x, self.problem.size, N_VGetArrayPointer(self.x.get()));
  self.time = 0.0;
  self.fresh = true;
  return ERKStepReInit(self.memory.get(), Implementation::derivative, 0.0, self.x.get()) == ARK_SUCCESS;
}

ErkSolver::Outcome ErkSolver::advance(const void* context, double t_end, double* x) noexcept {
  Implementation& self = *implementation_;
  void* const memory = self.memory.get();
  self.context = context;
  // The first guess of a step is the whole segment; the error control shortens it where it must.
  if (self.fresh && ERKStepSetInitStep(memory, t_end) != ARK_SUCCESS) return Outcome::failed;
  self.fresh = false;
  if (ERKStepSetStopTime(memory, t_end) != ARK_SUCCESS) return Outcome::failed;
  const int flag = ERKStepEvolve(memory, t_end, self.x.get(), &self.time, ARK_NORMAL);
  if (flag < 0) return Outcome::failed;
  const double* const state = N_VGetArrayPointer(self.x.get());
  for (int i = 0; i < self.problem.size; ++i) {
    if (!std::isfinite(state[i])) return Outcome::failed;
  }
  std::copy_n(state, self.problem.size, x);
  if (flag != ARK_ROOT_RETURN) return Outcome::reached;
  if (ERKStepGetRootInfo(memory, self.fired.data()) != ARK_SUCCESS) return Outcome::failed;
  const auto first = std::find_if(self.fired.begin(), self.fired.end(), [](int f) { return f != 0; });
  self.event = int(first - self.fired.begin());
  return first == self.fired.end() ? Outcome::failed : Outcome::event;
}

double ErkSolver::time() const noexcept {
  return implementation_->time;
}
int ErkSolver::event() const noexcept {
  return implementation_->event;
}

}  // namespace sextant
