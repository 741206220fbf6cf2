#include "sextant/event_exact/cvode_event_engine.hpp"

#include <algorithm>
#include <array>

namespace sextant {
namespace {

using State = EventExactSystem::State;

/// The estimator's flux is held to the tolerance of the machine's.
std::array<double, EventExactSystem::size> absolute(const Tolerances& tolerances) noexcept {
  std::array<double, EventExactSystem::size> t;
  t.fill(tolerances.flux);
  t[EventExactSystem::Plant::omega] = tolerances.speed;
  t[EventExactSystem::Plant::theta] = tolerances.angle;
  t[EventExactSystem::torque_reference] = tolerances.appended;
  std::fill(t.begin() + EventExactSystem::meter, t.end(), tolerances.appended);
  return t;
}

/// Such a run stops at each switching.
CvodeSolver solver(int event_count, const CvodeParameters& parameters) {
  const Tolerances tolerances = parameters.tolerances(true);
  return {ode_problem<EventExactSystem>(event_count, EventExactSystem::meter), parameters,
          tolerances.relative, absolute(tolerances)};
}

}  // namespace

CvodeEventEngine::CvodeEventEngine(const CvodeParameters& parameters, double max_piece)
    : with_events_{solver(EventExactSystem::event_count, parameters)},
      smooth_{solver(0, parameters)},
      max_piece_{max_piece} {}

EventPiece CvodeEventEngine::advance(EventExactSystem& system, double duration, bool detect) noexcept {
  CvodeSolver& solver = detect ? with_events_ : smooth_;
  if (active_ != &solver) {
    if (!solver.restart(system.state().data())) return {};
    active_ = &solver;
  }
  const double begin = solver.time();
  State x;
  const CvodeSolver::Outcome outcome =
      solver.advance(&system, begin + std::min(duration, max_piece_), x.data());
  if (outcome == CvodeSolver::Outcome::failed) return {};
  system.continue_at(x);
  const bool event = outcome == CvodeSolver::Outcome::event;
  return {event ? EventOutcome::event : EventOutcome::reached, solver.time() - begin,
          event ? solver.event() : -1};
}

}  // namespace sextant
