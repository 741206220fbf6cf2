#pragma once

#include <array>

#include "sextant/event_exact/event_engine_outcome.hpp"
#include "sextant/event_exact/event_exact_system.hpp"
#include "sextant/plant/hermite_path.hpp"

namespace sextant {

/// Moves an event-exact system by the classical Runge-Kutta method of order 4; events are located on the
/// step's cubic Hermite interpolant by bracketed secants and the state is taken from it there. With steps of
/// 10 µs and a time constant of 4 ms the interpolation error is some 1e-13 of the fluxes.
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", II.1 and II.6.
class FixedStepEventEngine {
 public:
  using State = EventExactSystem::State;

  /// Longest step [s]; a machine that is too fast for it gets shorter ones, as with `FixedStepIntegrator`.
  explicit FixedStepEventEngine(double max_step) noexcept : max_step_{max_step} {}

  /// One step towards `duration` [s] from now, or to the first event in it; `detect` false runs past events.
  [[nodiscard]] EventPiece advance(EventExactSystem& system, double duration, bool detect) noexcept;

  /// The right-hand side or the state has jumped.
  void restart() noexcept { slope_known_ = false; }

 private:
  using Path = HermitePath<State>;

  /// An event and the fraction of the step at which it has just come.
  struct Found {
    int event{-1};  ///< −1 where none comes
    double s{2.0};
  };
  static Found first_event(const EventExactSystem& system, const Path& path) noexcept;
  /// Value of an event function at a fraction of the step.
  struct Point {
    double s, g;
  };
  /// Fraction at which the event function, known at the beginning, in the middle and at the end, has just
  /// fallen below zero, by no more than the tolerance.
  static double locate(const EventExactSystem& system, const Path& path, int event,
                       const std::array<double, 3>& g) noexcept;
  /// Where the parabola through the three values falls to `aim`; may be NaN or outside of the step.
  static double root_of_parabola(const std::array<double, 3>& g, double aim) noexcept;

  double max_step_;  ///< [s]
  State slope_{};    ///< dx/dt at the system's present state
  bool slope_known_{false};
};

}  // namespace sextant
