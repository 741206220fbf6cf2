#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "virtual_time/injection.hpp"

namespace sextant::test {

/// One run of an injection.
struct InjectionPlan {
  std::uint64_t seed{1};
  std::size_t point{0};      ///< of the injection's operating points
  bool real_sensors{false};  ///< with gains, offsets, noise, converters of 12 bits and an encoder
  bool just_inside{false};   ///< the cause stays just inside the limit
};

/// What became of an injection in one run.
struct InjectionResult {
  bool started{false};            ///< torque, and no fault, until the cause began
  bool shown{false};              ///< the cause was observable, for longer than its bound or until FAULT
  bool raised{false};             ///< the drive went to FAULT
  bool named{false};              ///< the injection's fault is among those that latched
  bool gates_off{true};           ///< in every period in FAULT
  Fault first{};                  ///< that latched; meaningful while `raised`
  std::int64_t since_cause_ns{};  ///< from the beginning of the cause to FAULT [ns]
  std::int64_t reaction_ns{};     ///< from the first period in which it shows to FAULT, at least 0 [ns]

  /// True where the injection's fault came, for no other reason, and with it gates off.
  [[nodiscard]] bool is_reaction() const noexcept { return started && raised && named && gates_off; }
};

/// Sensors as they are.
inline SensorParameters real_sensors(CampaignCase& c) {
  SensorParameters p;
  p.current = {.noise = 0.2, .range = 300.0, .bits = 12};
  for (PhaseSensorError& phase : p.phases) {
    phase = {.gain_error = 0.02 * random_sign(c), .offset = 0.5 * random_sign(c)};
  }
  p.voltage = {.gain_error = 0.01 * random_sign(c), .noise = 1.0, .range = 800.0, .bits = 12};
  p.encoder = {.lines = 1024, .speed = EncoderSpeed::period, .window_periods = 20};
  p.seed = c.seed;
  return p;
}

/// The case of a plan, prepared for the drive.
inline CampaignCase prepared(const Injection& injection, const InjectionPlan& plan) {
  CampaignCase c{plan.seed};
  c.rig.omega_m = injection.points[plan.point].omega_m;
  c.rig.torque = injection.points[plan.point].torque;
  c.just_inside = plan.just_inside;
  if (plan.real_sensors) c.rig.sensors = real_sensors(c);
  if (injection.prepare) injection.prepare(c);
  return c;
}

/// Follows an injection from period to period.
class InjectionWatch {
 public:
  InjectionWatch(const Injection& injection, const CampaignCase& c, VirtualRig& rig)
      : injection_{injection}, at_ns_{c.at_ns}, rig_{rig} {
    if (injection.make_shows) shows_ = injection.make_shows();
    rig_.on_period = [this](const Telemetry<double>& t) { see(t); };
  }
  ~InjectionWatch() { rig_.on_period = {}; }
  InjectionWatch(const InjectionWatch&) = delete;
  InjectionWatch& operator=(const InjectionWatch&) = delete;

  [[nodiscard]] InjectionResult result() const noexcept {
    InjectionResult result = result_;
    result.shown = shown_ns_ != never_ns && (result.raised || last_ns_ - shown_ns_ > injection_.bound_ns);
    if (result.raised) result.since_cause_ns = fault_ns_ - at_ns_;
    if (result.raised && result.shown) result.reaction_ns = std::max<std::int64_t>(0, fault_ns_ - shown_ns_);
    return result;
  }

 private:
  void see(const Telemetry<double>& t) {
    if (t.t_ns < at_ns_) result_.started = makes_torque(t.state) && !t.latched.any();
    // FAULT ends what there is to see: the gates are off.
    const bool shows = fault_ns_ == never_ns && (!shows_ || shows_(rig_, t));
    if (t.t_ns < at_ns_ && !injection_.must_last) return;
    last_ns_ = t.t_ns;
    if (shows && shown_ns_ == never_ns) shown_ns_ = t.t_ns;
    if (!shows && injection_.must_last && t.state != DriveState::fault) shown_ns_ = never_ns;
    if (t.t_ns < at_ns_) return;
    if (t.state != DriveState::fault) return;
    if (fault_ns_ == never_ns) {
      fault_ns_ = t.t_ns;
      result_.raised = true;
      result_.first = t.first_fault;
    }
    result_.gates_off = result_.gates_off && t.pattern.last_state() == gates_off;
    result_.named = result_.named || is_named(t.latched);
  }

  [[nodiscard]] bool is_named(FaultSet latched) const noexcept {
    return latched.test(injection_.fault) ||
           std::ranges::any_of(injection_.also, [latched](Fault fault) { return latched.test(fault); });
  }

  const Injection& injection_;
  std::int64_t at_ns_;
  VirtualRig& rig_;
  Injection::Shows shows_{};
  InjectionResult result_{};
  std::int64_t shown_ns_{never_ns};
  std::int64_t fault_ns_{never_ns};
  std::int64_t last_ns_{never_ns};  ///< the newest period [ns]
};

/// Runs the case until the cause has ended.
inline InjectionResult run_injection(const Injection& injection, const CampaignCase& c, VirtualRig& rig) {
  InjectionWatch watch{injection, c, rig};
  rig.torque = c.start_torque.value_or(rig.torque);
  rig.run_until(c.at_ns);
  if (injection.inject) injection.inject(rig, c);
  rig.run_until(c.at_ns + injection.lasts_ns);
  return watch.result();
}

}  // namespace sextant::test
