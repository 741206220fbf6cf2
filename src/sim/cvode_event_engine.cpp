#include "sextant/sim/cvode_event_engine.hpp"

#include <algorithm>
#include <array>

namespace sextant {
namespace {

using State = EventExactSystem::State;
using Jacobian = EventExactSystem::Jacobian;

OdeProblem problem(int event_count) noexcept {
  return {EventExactSystem::size,
          event_count,
          [](const void* system, const double* x, double* dx) noexcept {
            State slope;
            static_cast<const EventExactSystem*>(system)->derivative(Eigen::Map<const State>(x), slope);
            Eigen::Map<State>{dx} = slope;
          },
          [](const void* system, const double* x, double* j) noexcept {
            Jacobian matrix;
            static_cast<const EventExactSystem*>(system)->jacobian(Eigen::Map<const State>(x), matrix);
            Eigen::Map<Jacobian>{j} = matrix;
          },
          [](const void* system, const double* x, double* g) noexcept {
            EventExactSystem::Events values;
            static_cast<const EventExactSystem*>(system)->events(Eigen::Map<const State>(x), values);
            std::copy(values.begin(), values.end(), g);
          },
          EventExactSystem::meter};
}

/// The estimator's flux is held to the tolerance of the machine's.
std::array<double, EventExactSystem::size> tolerances(const CvodeParameters& parameters) noexcept {
  std::array<double, EventExactSystem::size> t;
  t.fill(parameters.flux_tolerance);
  t[EventExactSystem::Plant::omega] = parameters.speed_tolerance;
  t[EventExactSystem::Plant::theta] = parameters.angle_tolerance;
  t[EventExactSystem::torque_reference] = parameters.appended_tolerance;
  std::fill(t.begin() + EventExactSystem::meter, t.end(), parameters.appended_tolerance);
  return t;
}

}  // namespace

CvodeEventEngine::CvodeEventEngine(const CvodeParameters& parameters, double max_piece)
    : with_events_{problem(EventExactSystem::event_count), parameters, tolerances(parameters)},
      smooth_{problem(0), parameters, tolerances(parameters)},
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
