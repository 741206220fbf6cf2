#pragma once

#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include <sundials/sundials_context.hpp>
#include <sundials/sundials_nvector.h>

#include "sextant/plant/ode_problem.hpp"

namespace sextant {

struct FreeVector {
  void operator()(N_Vector v) const noexcept { N_VDestroy(v); }
};

/// A handle of SUNDIALS that is freed with its owner.
template <class Handle, class Free>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;

/// What every solver of SUNDIALS needs besides its own memory: the problem, the vectors, the functions that
/// SUNDIALS calls back, and where the last advance stopped.
struct SundialsSolution {
  /// library: its name in the message of `require`. relative_tolerance: for the problem's relative states
  /// [-].
  SundialsSolution(const char* library, const OdeProblem& problem, double relative_tolerance);
  SundialsSolution(const SundialsSolution&) = delete;
  SundialsSolution& operator=(const SundialsSolution&) = delete;

  /// Throws std::runtime_error unless the call was good.
  void require(bool good, const char* call) const;

  /// Makes the vectors, x all zero. absolute_tolerance: one for each state.
  void allocate(N_Vector (*make)(int, bool, SUNContext), std::span<const double> absolute_tolerance);

  /// Of root finding, for every event function: only falls count.
  [[nodiscard]] std::vector<int> all_falling() const;

  /// Calls `advance`, which is to run to t = 1, on a harmless problem in place of the own one: SUNDIALS
  /// allocates in a solver's first step, and so does it while constructing. The problem is dx/dt = 1 − x with
  /// events at 0.5.
  template <class Advance>
  void prime(Advance&& advance) {
    const OdeProblem real = problem;
    problem = harmless(real);
    context = &real;
    advance();
    problem = real;
    context = nullptr;
  }

  /// Puts x in the place of the state, at time zero.
  void set_state(const double* state) noexcept;

  /// After a call of the solver that returned `flag`, negative for a failure: copies x to `state` and takes
  /// the lowest event. root_info: the library's function that tells which events have fired, nullptr where
  /// none has.
  [[nodiscard]] SolverOutcome outcome(int flag, int (*root_info)(void* memory, int* fired), void* memory,
                                      double* state) noexcept;

  /// The callbacks get this as their user data.
  [[nodiscard]] void* as_user_data() noexcept { return this; }
  static int derivative(sunrealtype t, N_Vector x, N_Vector dx, void* user);
  static int events(sunrealtype, N_Vector x, sunrealtype* g, void* user);
  /// The weight of an error of each state: 1 / (relative |x| + absolute), |x| that of the vector where the
  /// state is a component of one.
  static int weights(N_Vector x, N_Vector w, void* user);
  /// Failures are reported by return values; SUNDIALS' own messages would go to stderr from the control
  /// thread.
  static void discard_message(int, const char*, const char*, char*, void*) {}

  const char* library;
  OdeProblem problem;
  double relative_tolerance;  ///< [-]
  const void* context{nullptr};
  sundials::Context sundials{};
  Owned<N_Vector, FreeVector> x{};
  Owned<N_Vector, FreeVector> tolerance{};
  std::vector<int> fired;  ///< event functions that stopped the last advance
  double time{};           ///< since the last restart [s]
  int event{};             ///< the lowest of the fired ones

 protected:
  ~SundialsSolution() = default;

 private:
  /// Hands the state out; false, and nothing is copied, where it is not finite.
  [[nodiscard]] bool copy_state(double* state) const noexcept;
  /// Takes the lowest of the `fired` events.
  [[nodiscard]] SolverOutcome take_event() noexcept;
  /// Of the size of `real`, which is its context.
  [[nodiscard]] static OdeProblem harmless(const OdeProblem& real) noexcept;
};

}  // namespace sextant
