#include "sextant/event_exact/fixed_step_event_engine.hpp"

#include <algorithm>
#include <cmath>

#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/runge_kutta.hpp"

namespace sextant {
namespace {

using Events = EventExactSystem::Events;

/// How far below zero an event function may be at its event: 1e-9 N·m pass in 4e-15 s.
constexpr double tolerance(int event) noexcept {
  return event == ContinuousComparators::torque_above || event == ContinuousComparators::torque_below ? 1e-9
                                                                                                      : 1e-13;
}

}  // namespace

EventPiece FixedStepEventEngine::advance(EventExactSystem& system, double duration, bool detect) noexcept {
  // The same bound as that of the sampled engine.
  const double bound = FixedStepIntegrator<EventExactSystem::Plant>::longest_step(system.plant());
  const double h = std::min(std::min(duration, max_step_), bound);
  Path path;
  path.x0 = system.state();
  if (!slope_known_) system.derivative(path.x0, slope_);
  const auto slope = [&system](double, const State& x, State& dx) noexcept { system.derivative(x, dx); };
  path.x1 = runge_kutta_step(slope, path.x0, slope_, h);
  State slope_after;
  system.derivative(path.x1, slope_after);
  if (!path.x1.allFinite()) return {EventOutcome::failed, 0.0, -1};
  if (detect) {
    path.d0 = h * slope_;
    path.d1 = h * slope_after;
    const Found found = first_event(system, path);
    if (found.event >= 0) {
      system.continue_at(path.at(found.s));
      slope_known_ = false;
      return {EventOutcome::event, found.s * h, found.event};
    }
  }
  system.continue_at(path.x1);
  slope_ = slope_after;
  slope_known_ = true;
  return {EventOutcome::reached, h, -1};
}

FixedStepEventEngine::Found FixedStepEventEngine::first_event(const EventExactSystem& system,
                                                              const Path& path) noexcept {
  Events middle, after;
  system.events(path.x1, after);
  // The middle is evaluated too, so that a dip within the step is rarely missed.
  system.events(path.at(0.5), middle);
  Found first;
  for (int i = 0; i < EventExactSystem::event_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (middle[k] >= 0.0 && after[k] >= 0.0) continue;
    if (middle[k] >= 0.0 && first.s <= 0.5) continue;
    const double before = system.event(path.x0, i);
    if (before < 0.0) return {i, 0.0};
    const double s = locate(system, path, i, {before, middle[k], after[k]});
    if (s < first.s) first = {i, s};
  }
  return first;
}

double FixedStepEventEngine::locate(const EventExactSystem& system, const Path& path, int event,
                                    const std::array<double, 3>& g) noexcept {
  constexpr int max_iterations = 60;
  const double tol = tolerance(event);
  // Aims at half the tolerance below zero, so that the result lies beyond the event.
  const double aim = -0.5 * tol;
  const bool in_first_half = g[1] < 0.0;
  Point before = in_first_half ? Point{0.0, g[0]} : Point{0.5, g[1]};
  Point after = in_first_half ? Point{0.5, g[1]} : Point{1.0, g[2]};
  Point last = before;
  double s = root_of_parabola(g, aim);
  for (int n = 0; n < max_iterations && after.g < -tol; ++n) {
    if (!(s > before.s && s < after.s)) s = 0.5 * (before.s + after.s);
    if (s <= before.s || s >= after.s) break;
    const Point now{s, system.event(path.at(s), event)};
    (now.g < 0.0 ? after : before) = now;
    s = now.s - (now.g - aim) * (now.s - last.s) / (now.g - last.g);
    last = now;
  }
  return after.s;
}

double FixedStepEventEngine::root_of_parabola(const std::array<double, 3>& g, double aim) noexcept {
  const double c = g[0] - aim;
  const double b = -3.0 * g[0] + 4.0 * g[1] - g[2];
  const double a = 2.0 * g[0] - 4.0 * g[1] + 2.0 * g[2];
  const double root = std::sqrt(b * b - 4.0 * a * c);
  // The smaller of the two without cancellation, for a function that falls.
  return b < 0.0 ? 2.0 * c / (-b + root) : (-b - root) / (2.0 * a);
}

}  // namespace sextant
