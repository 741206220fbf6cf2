#pragma once

#include <algorithm>
#include <cstdint>

#include "harness/fault_injections.hpp"

namespace sextant::test {

/// What became of one injection in one run.
struct InjectionResult {
  bool started{false};         ///< torque, and no fault, until the cause began
  bool shown{false};           ///< it could be seen
  bool raised{false};          ///< the drive went to FAULT
  bool named{false};           ///< the injection's fault is among those that latched
  bool gates_off{true};        ///< in every period from FAULT on
  Fault first{};               ///< that latched; meaningful while `raised`
  std::int64_t reaction_ns{};  ///< from the first period in which it shows to FAULT, at least 0 [ns]
};

/// Sensors as they are: gains, offsets, noise, converters of 12 bits, an encoder.
inline SensorParameters real_sensors(CampaignCase& c) {
  const auto sign = [&c] { return c.between(0, 1) == 0 ? -1.0 : 1.0; };
  SensorParameters p;
  p.current = {.noise = 0.2, .range = 300.0, .bits = 12};
  for (PhaseSensorError& phase : p.phases) phase = {.gain_error = 0.02 * sign(), .offset = 0.5 * sign()};
  p.voltage = {.gain_error = 0.01 * sign(), .noise = 1.0, .range = 800.0, .bits = 12};
  p.encoder = {.lines = 1024, .speed = EncoderSpeed::period, .window_periods = 20};
  p.seed = c.seed;
  return p;
}

/// Prepares the case: with the sensors it has, and the cause of the injection.
inline void prepare(const Injection& injection, CampaignCase& c) {
  if (injection.prepare) injection.prepare(c);
}

/// Runs the case until the cause has ended.
inline InjectionResult run_injection(const Injection& injection, CampaignCase& c, VirtualRig& rig) {
  InjectionResult result;
  result.started = rig.start();
  rig.run_until(c.at_ns);
  result.started = result.started && makes_torque(rig.now().state) && !rig.now().latched.any();
  if (!result.started) return result;
  if (injection.inject) injection.inject(rig, c);
  rig.forget();
  std::int64_t shown_ns = injection.shows ? never_ns : on_grid(c.at_ns);
  rig.on_period = [&](const Telemetry<double>& t) {
    if (t.t_ns < c.at_ns) return;
    if (rig.first_fault_ns == never_ns || rig.first_fault_ns == t.t_ns) {
      if (shown_ns == never_ns && injection.shows(rig, t)) shown_ns = t.t_ns;
    }
    if (t.state != DriveState::fault) return;
    result.gates_off = result.gates_off && t.switch_state == gates_off;
    result.named = result.named || t.latched.test(injection.fault);
  };
  rig.run_until(c.at_ns + injection.lasts_ns);
  rig.on_period = {};
  result.raised = rig.first_fault_ns != never_ns;
  result.shown = shown_ns != never_ns;
  result.first = rig.now().first_fault;
  if (result.raised && result.shown) {
    result.reaction_ns = std::max<std::int64_t>(0, rig.first_fault_ns - shown_ns);
  }
  return result;
}

}  // namespace sextant::test
