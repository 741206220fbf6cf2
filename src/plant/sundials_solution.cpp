#include "sundials_solution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace sextant {
namespace {

constexpr int unrecoverable = -1;

}  // namespace

SundialsSolution::SundialsSolution(const char* library_name, const OdeProblem& ode, double relative)
    : library{library_name},
      problem{ode},
      relative_tolerance{relative},
      fired(static_cast<std::size_t>(ode.event_count), 0) {}

void SundialsSolution::require(bool good, const char* call) const {
  if (!good) throw std::runtime_error(std::string(library) + " cannot be set up: " + call + " failed");
}

void SundialsSolution::allocate(N_Vector (*make)(int, bool, SUNContext),
                                std::span<const double> absolute_tolerance) {
  x.reset(make(problem.size, problem.last_is_uncontrolled, sundials));
  tolerance.reset(make(problem.size, problem.last_is_uncontrolled, sundials));
  require(x && tolerance, "N_VNew_Serial");
  N_VConst(0.0, x.get());
  std::copy(absolute_tolerance.begin(), absolute_tolerance.end(), N_VGetArrayPointer(tolerance.get()));
}

std::vector<int> SundialsSolution::all_falling() const {
  return std::vector<int>(fired.size(), -1);
}

OdeProblem SundialsSolution::harmless(const OdeProblem& real) noexcept {
  return {real.size, real.event_count,
          [](const void* self, double, const double* state, double* slope) noexcept {
            for (int i = 0; i < static_cast<const OdeProblem*>(self)->size; ++i) slope[i] = 1.0 - state[i];
          },
          [](const void* self, double, const double*, double* j) noexcept {
            const int n = static_cast<const OdeProblem*>(self)->size;
            for (int i = 0; i < n * n; ++i) j[i] = i % (n + 1) == 0 ? -1.0 : 0.0;
          },
          [](const void* self, const double* state, double* g) noexcept {
            std::fill_n(g, static_cast<const OdeProblem*>(self)->event_count, 0.5 - *state);
          }};
}

void SundialsSolution::set_state(const double* state) noexcept {
  std::copy_n(state, problem.size, N_VGetArrayPointer(x.get()));
  time = 0.0;
}

bool SundialsSolution::copy_state(double* state) const noexcept {
  const double* const own = N_VGetArrayPointer(x.get());
  for (int i = 0; i < problem.size; ++i) {
    if (!std::isfinite(own[i])) return false;
  }
  std::copy_n(own, problem.size, state);
  return true;
}

SolverOutcome SundialsSolution::outcome(int flag, int (*root_info)(void*, int*), void* memory,
                                        double* state) noexcept {
  if (flag < 0 || !copy_state(state)) return SolverOutcome::failed;
  if (root_info == nullptr) return SolverOutcome::reached;
  return root_info(memory, fired.data()) == 0 ? take_event() : SolverOutcome::failed;
}

SolverOutcome SundialsSolution::take_event() noexcept {
  const auto first = std::find_if(fired.begin(), fired.end(), [](int f) { return f != 0; });
  event = int(first - fired.begin());
  return first == fired.end() ? SolverOutcome::failed : SolverOutcome::event;
}

int SundialsSolution::derivative(sunrealtype t, N_Vector x, N_Vector dx, void* user) {
  const auto& self = *static_cast<const SundialsSolution*>(user);
  double* const slope = N_VGetArrayPointer(dx);
  self.problem.derivative(self.context, t, N_VGetArrayPointer(x), slope);
  // The norms of SUNDIALS compare false with NaN, so that it would take one for a small error.
  double sum = 0.0;
  for (int i = 0; i < self.problem.size; ++i) sum += slope[i];
  return std::isfinite(sum) ? 0 : unrecoverable;
}

int SundialsSolution::events(sunrealtype, N_Vector x, sunrealtype* g, void* user) {
  const auto& self = *static_cast<const SundialsSolution*>(user);
  self.problem.events(self.context, N_VGetArrayPointer(x), g);
  return 0;
}

int SundialsSolution::weights(N_Vector x, N_Vector w, void* user) {
  const auto& self = *static_cast<const SundialsSolution*>(user);
  const double* const state = N_VGetArrayPointer(x);
  const double* const absolute = N_VGetArrayPointer(self.tolerance.get());
  double* const weight = N_VGetArrayPointer(w);
  int i = 0;
  for (; i < self.problem.vector_states; i += 2) {
    const double magnitude = std::sqrt(state[i] * state[i] + state[i + 1] * state[i + 1]);
    weight[i] = 1.0 / (self.relative_tolerance * magnitude + absolute[i]);
    weight[i + 1] = 1.0 / (self.relative_tolerance * magnitude + absolute[i + 1]);
  }
  for (; i < self.problem.size; ++i) {
    const double relative = i < self.problem.relative_states ? self.relative_tolerance : 0.0;
    weight[i] = 1.0 / (relative * std::abs(state[i]) + absolute[i]);
  }
  return 0;
}

}  // namespace sextant
