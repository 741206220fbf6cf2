#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

namespace sextant {

/// The equations that a variable-step solver integrates, as plain functions of a context.
struct OdeProblem {
  int size{};         ///< number of states [-]
  int event_count{};  ///< number of event functions; 0 runs without root finding [-]
  /// dx/dt at the time since the last restart [s].
  void (*derivative)(const void* context, double t, const double* x, double* dx) noexcept {};
  /// ∂(dx/dt)/∂x, column-major; for implicit methods.
  void (*jacobian)(const void* context, double t, const double* x, double* j) noexcept {};
  /// Event functions; an event is a fall through zero.
  void (*events)(const void* context, const double* x, double* g) noexcept {};
  /// The states from here on are integrals that nothing depends on and that grow without bound, as a meter's:
  /// the relative tolerance does not count for them, or their error would grow with them.
  int relative_states{std::numeric_limits<int>::max()};
  /// The states before this one are pairs of components of space vectors: the relative tolerance counts for
  /// the magnitude, so that a component that passes through zero asks for no more accuracy than the other.
  int vector_states{0};
  /// The last state has no say in the error of a step.
  bool last_is_uncontrolled{false};
};

/// Where a solver stopped: at the end of the segment, at an event before it, or nowhere of use.
enum class SolverOutcome : std::uint8_t { reached, event, failed };

/// `function` of a system at the state x, and at the time t where it depends on it, for `OdeProblem`.
template <class System, class Result, auto function>
void evaluate(const void* context, [[maybe_unused]] double t, const double* x, double* result) noexcept {
  using State = typename System::State;
  const auto& system = *static_cast<const System*>(context);
  const State state = Eigen::Map<const State>(x);
  Result value;
  if constexpr (std::invocable<decltype(function), const System&, double, const State&, Result&>)
    (system.*function)(t, state, value);
  else
    (system.*function)(state, value);
  Eigen::Map<Result>{result} = value;
}

/// The problem of a system with the functions of `DrivePlant`: derivative(x, dx), jacobian(x, j), and
/// events(x, g) where event_count is not zero. A system that depends on the time has
/// derivative(t, x, dx) and jacobian(t, x, j). The first four states are stator and rotor flux.
template <class System>
[[nodiscard]] OdeProblem ode_problem(int event_count, int relative_states) noexcept {
  constexpr int fluxes = 4;
  using State = typename System::State;
  OdeProblem problem{.size = int(State::RowsAtCompileTime),
                     .event_count = event_count,
                     .derivative = evaluate<System, State, &System::derivative>,
                     .jacobian = evaluate<System, typename System::Jacobian, &System::jacobian>,
                     .relative_states = relative_states,
                     .vector_states = fluxes};
  if constexpr (requires { System::last_is_uncontrolled; })
    problem.last_is_uncontrolled = System::last_is_uncontrolled;
  if constexpr (requires { typename System::Events; }) {
    problem.events = [](const void* system, const double* x, double* g) noexcept {
      typename System::Events values;
      static_cast<const System*>(system)->events(Eigen::Map<const State>(x), values);
      std::copy(values.begin(), values.end(), g);
    };
  }
  return problem;
}

}  // namespace sextant
