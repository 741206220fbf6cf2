#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/event_exact/event_engine_outcome.hpp"
#include "sextant/event_exact/event_exact_parameters.hpp"
#include "sextant/event_exact/event_exact_system.hpp"

namespace sextant {

/// What acts on an event-exact system over a stretch of time, in straight lines.
struct EventExactStretch {
  std::int64_t duration_ns{};  ///< [ns]
  double torque_reference{};   ///< at the beginning [N·m]
  double reference_slope{};    ///< [N·m/s]
  double u_dc{};               ///< [V]
  double tau_l{};              ///< load torque, constant [N·m]
  bool imposed_speed{false};   ///< the speed follows speed_slope
  double speed_slope{};        ///< [rad/s²]
};

/// Runs an event-exact system through stretches of time: integrates from event to event, switches there,
/// and restarts the integration. A switching state lasts at least the minimum dwell: events that come sooner
/// are deferred to its end, which bounds the switching where events would follow each other without end.
template <class Engine>
class EventExactSimulation {
 public:
  /// System and engine are not owned.
  EventExactSimulation(const EventExactParameters& parameters, EventExactSystem& system,
                       Engine& engine) noexcept
      : dwell_{double(parameters.minimum_dwell_ns) * 1e-9},
        max_events_{parameters.max_events},
        since_switching_{dwell_},
        system_{system},
        engine_{engine} {}

  /// Runs one stretch. `observe(duration)` is called after each piece without an event in it, with the system
  /// at its end and before anything switches, and ends the stretch by returning false; `switched()` is called
  /// after each change of the switching state. False when the integration failed or the events did not end.
  template <class Observe, class Switched>
  [[nodiscard]] bool run(const EventExactStretch& stretch, Observe&& observe, Switched&& switched);

  /// False once a stretch has had more events than it may.
  [[nodiscard]] bool events_ended() const noexcept { return events_ended_; }
  /// Events deferred by the minimum dwell so far. [-]
  [[nodiscard]] std::int64_t dwell_limited() const noexcept { return dwell_limited_; }
  /// Events so far. [-]
  [[nodiscard]] std::int64_t events() const noexcept { return events_; }

 private:
  /// Shorter rests of a stretch are left out: nothing moves in them, and CVODE refuses them. [s]
  static constexpr double negligible = 1e-14;

  void begin(const EventExactStretch& stretch) noexcept {
    system_.set_reference(stretch.torque_reference, stretch.reference_slope);
    system_.set_surroundings(stretch.u_dc, stretch.tau_l, stretch.imposed_speed, stretch.speed_slope);
    engine_.restart();
  }

  /// False while the minimum dwell forbids it.
  template <class Switched>
  bool try_to_settle(int event, Switched&& switched) {
    if (since_switching_ < dwell_ - negligible) return false;
    if (system_.settle(event)) {
      since_switching_ = 0.0;
      switched();
    }
    engine_.restart();
    return true;
  }

  double dwell_;  ///< [s]
  std::int64_t max_events_;
  double since_switching_;  ///< [s]
  std::int64_t dwell_limited_{0};
  std::int64_t events_{0};
  bool events_ended_{true};
  int event_{-1};  ///< that the engine has stopped at, not yet in force; one may end a stretch
  EventExactSystem& system_;
  Engine& engine_;
};

template <class Engine>
template <class Observe, class Switched>
bool EventExactSimulation<Engine>::run(const EventExactStretch& stretch, Observe&& observe,
                                       Switched&& switched) {
  const bool jumps = std::abs(stretch.torque_reference - system_.reference()) > 1e-9;
  begin(stretch);
  double left = double(stretch.duration_ns) * 1e-9;
  const std::int64_t limit = events_ + 1000 + std::int64_t(left * double(max_events_));
  // An event that ended the last stretch, or a jump of the reference; without either, events within the dwell
  // are still to be found and counted.
  bool pending = event_ >= 0 || jumps || since_switching_ >= dwell_ - negligible;
  while (left > negligible) {
    if (pending) pending = !try_to_settle(event_, switched);
    event_ = -1;
    const double span = pending ? std::min(left, dwell_ - since_switching_) : left;
    const EventPiece piece = engine_.advance(system_, span, !pending);
    events_ended_ = events_ <= limit;
    if (piece.outcome == EventOutcome::failed || !events_ended_) return false;
    left -= piece.duration;
    since_switching_ += piece.duration;
    if (piece.duration > 0.0 && !observe(piece.duration)) return true;
    if (piece.outcome != EventOutcome::event) continue;
    ++events_;
    event_ = piece.event;
    pending = true;
    if (since_switching_ < dwell_ - negligible) ++dwell_limited_;
  }
  return true;
}

}  // namespace sextant
