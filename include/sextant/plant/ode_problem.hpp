#pragma once

#include <algorithm>
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

/// The problem of a system with the functions of `DrivePlant`: derivative(x, dx), jacobian(x, j), and
/// events(x, g) where event_count is not zero. A system that depends on the time has
/// derivative(t, x, dx) and jacobian(t, x, j). The first four states are stator and rotor flux.
template <class System>
[[nodiscard]] OdeProblem ode_problem(int event_count, int relative_states) noexcept {
  constexpr int fluxes = 4;
  using State = typename System::State;
  using Jacobian = typename System::Jacobian;
  constexpr bool timed =
      requires(const System& s, double t, const State& x, State& dx) { s.derivative(t, x, dx); };
  OdeProblem problem{
      .size = int(State::RowsAtCompileTime),
      .event_count = event_count,
      .derivative =
          [](const void* system, [[maybe_unused]] double t, const double* x, double* dx) noexcept {
            const auto& self = *static_cast<const System*>(system);
            State slope;
            if constexpr (timed)
              self.derivative(t, Eigen::Map<const State>(x), slope);
            else
              self.derivative(Eigen::Map<const State>(x), slope);
            Eigen::Map<State>{dx} = slope;
          },
      .jacobian =
          [](const void* system, [[maybe_unused]] double t, const double* x, double* j) noexcept {
            const auto& self = *static_cast<const System*>(system);
            Jacobian matrix;
            if constexpr (timed)
              self.jacobian(t, Eigen::Map<const State>(x), matrix);
            else
              self.jacobian(Eigen::Map<const State>(x), matrix);
            Eigen::Map<Jacobian>{j} = matrix;
          },
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
