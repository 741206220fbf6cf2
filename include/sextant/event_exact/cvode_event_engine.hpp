#pragma once

#include "sextant/event_exact/event_engine_outcome.hpp"
#include "sextant/event_exact/event_exact_system.hpp"
#include "sextant/plant/cvode_parameters.hpp"
#include "sextant/plant/cvode_solver.hpp"

namespace sextant {

/// Moves an event-exact system by SUNDIALS CVODE, whose root finding stops at its events.
class CvodeEventEngine {
 public:
  /// Throws std::runtime_error when CVODE cannot be set up. Longest piece between two events [s].
  CvodeEventEngine(const CvodeParameters& parameters, double max_piece);

  /// Over `duration` [s], a longest piece at most, or to the first event in it; `detect` false runs past
  /// events.
  [[nodiscard]] EventPiece advance(EventExactSystem& system, double duration, bool detect) noexcept;

  /// The right-hand side or the state has jumped.
  void restart() noexcept { active_ = nullptr; }

 private:
  CvodeSolver with_events_;
  CvodeSolver smooth_;
  CvodeSolver* active_{nullptr};  ///< the solver that holds the system's solution
  double max_piece_;              ///< [s]
};

}  // namespace sextant
