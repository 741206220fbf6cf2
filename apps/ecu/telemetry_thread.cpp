#include "ecu/telemetry_thread.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "ecu/silent_drive.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

bool same_state(const Telemetry<double>& a, const Telemetry<double>& b) {
  return a.state == b.state && a.lockout == b.lockout && a.active == b.active && a.latched == b.latched;
}

double us(std::int64_t ns) {
  return double(ns) * 1e-3;
}

void fill_durations(RealTimeSample& sample, const TimingHistograms& histograms) {
  const LatencySummary latency = histograms.latency.summary();
  sample.wake_latency_p50_us = us(latency.p50_ns);
  sample.wake_latency_p99_us = us(latency.p99_ns);
  sample.wake_latency_p99_9_us = us(latency.p99_9_ns);
  sample.wake_latency_p99_99_us = us(latency.p99_99_ns);
  sample.wake_latency_max_us = us(latency.max_ns);
  const LatencySummary body = histograms.body.summary();
  sample.body_p50_us = us(body.p50_ns);
  sample.body_p99_us = us(body.p99_ns);
  sample.body_p99_9_us = us(body.p99_9_ns);
  sample.body_p99_99_us = us(body.p99_99_ns);
  sample.body_max_us = us(body.max_ns);
  for (std::size_t i = 0; i < stage_count; ++i) {
    const LatencySummary stage = histograms.stages[i].summary();
    sample.stages[i] = {us(stage.p50_ns), us(stage.p99_9_ns), us(stage.max_ns)};
  }
}

}  // namespace

std::string reason_for(const Telemetry<double>& t) {
  switch (t.state) {
    case DriveState::init:
      return "starting";
    case DriveState::standby:
      return t.command_sequence == 0 ? "no valid command yet" : "locked out until a valid disable";
    case DriveState::ready:
      return t.torque_motoring == 0.0 && t.torque_regenerating == 0.0
                 ? "no torque available at this speed and link voltage"
                 : "waiting for enable";
    case DriveState::magnetising:
      return "building up flux";
    case DriveState::torque:
      return "torque reference as requested";
    case DriveState::derated:
      return "torque reference below the request: less is available";
    case DriveState::fault:
      return std::string{to_string(t.first_fault)} + ": reset, then disable, then enable";
    case DriveState::shutdown:
      return "shut down";
  }
  return "";
}

void TelemetryThread::run() {
  next_statistics_ns_ = now_ns() + parameters_.statistics_ns;
  report_.start(now_ns());
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    look(now_ns());
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  drain_telemetry();
  drain_wakes();
  timing_.finish();
  publish_statistics();
  report_.hand_over(timing_.last());
}

void TelemetryThread::look(std::int64_t now_ns) {
  drain_telemetry();
  drain_wakes();
  watch_control_thread(now_ns);
  look_(now_ns);
}

void TelemetryThread::watch_control_thread(std::int64_t now_ns) {
  constexpr std::int64_t tell_every_ns = 50'000'000;
  if (!crossings_.control_silent(now_ns)) {
    next_silence_ns_ = now_ns;
    return;
  }
  if (now_ns < next_silence_ns_) return;
  next_silence_ns_ = now_ns + tell_every_ns;
  const std::int64_t silent_ns = now_ns - crossings_.heartbeat_ns.load(std::memory_order_acquire);
  publish_state(status_of_silent_drive(newest_),
                fmt::format("WATCHDOG: control thread silent for {} ms", silent_ns / 1'000'000));
  any_published_ = false;  // its next record tells how it stands, whatever was told before
}

void TelemetryThread::drain_telemetry() {
  Telemetry<double> telemetry;
  while (crossings_.telemetry.pop(telemetry)) {
    newest_ = telemetry;
    interval_.add(telemetry);
    if (!any_published_ || !same_state(telemetry, published_)) publish_state(telemetry);
    if (interval_.count() < parameters_.periods_per_sample) continue;
    sender_.write(interval_.record(), crossings_.telemetry.dropped());
    interval_.reset();
  }
}

void TelemetryThread::publish_state(const Telemetry<double>& telemetry) {
  publish_state(telemetry, reason_for(telemetry));
}

void TelemetryThread::publish_state(const Telemetry<double>& telemetry, const std::string& reason) {
  DriveStateSample sample{
      telemetry.t_ns,        telemetry.state, telemetry.lockout, telemetry.active, telemetry.latched, {},
      telemetry.fault_total, reason};
  if (telemetry.latched.any()) sample.first_fault = telemetry.first_fault;
  sender_.write(sample);
  published_ = telemetry;
  any_published_ = true;
}

void TelemetryThread::drain_wakes() {
  // Taken before the wake-ups, added after them: a miss that was over by then is in the ring by now, but for
  // one whose work still runs, and that finds what the sample has left over.
  const bool sampled = crossings_.scheduler.update();
  StageRecord stages;
  while (crossings_.stages.pop(stages)) timing_.add(stages);
  WakeRecord wake;
  while (crossings_.wakes.pop(wake)) {
    timing_.add(wake);
    report_.add(wake);
    if (wake.deadline_ns >= next_statistics_ns_) publish_statistics();
  }
  if (sampled) timing_.add(crossings_.scheduler.value());
}

void TelemetryThread::publish_statistics() {
  sender_.write(sample());
  timing_.reset_interval();
  next_statistics_ns_ = timing_.last().deadline_ns + parameters_.statistics_ns;
}

RealTimeSample TelemetryThread::sample() const {
  const WakeRecord& last = timing_.last();
  const SchedulerSample& scheduler = timing_.scheduler();
  RealTimeSample sample{
      .t_ns = last.deadline_ns,
      .period_ns = std::uint32_t(parameters_.period_ns),
      .wake_every_periods = parameters_.wake_every_periods,
      .wait = parameters_.wait,
      .policy = parameters_.policy,
      .periods = last.periods,
      .periods_skipped = last.periods_skipped,
      .overruns = last.overruns,
      .misses = timing_.causes(),
      .misses_without_gap = timing_.without_gap(),
      .gaps = timing_.gaps(),
      .longest_gap_us = us(timing_.interval().longest_gap_ns),
      .page_faults = scheduler.minor_faults + scheduler.major_faults,
      .voluntary_switches = scheduler.voluntary_switches,
      .involuntary_switches = scheduler.involuntary_switches,
      .run_delay_us = us(scheduler.run_delay_ns),
      .steal_us = us(scheduler.steal_ns),
      .telemetry_dropped = crossings_.telemetry.dropped(),
      .commands_received = crossings_.commands_accepted.load(std::memory_order_relaxed),
      .commands_rejected = crossings_.commands_rejected.load(std::memory_order_relaxed),
      .real_time_scheduling = parameters_.real_time_scheduling,
      .memory_locked = parameters_.memory_locked,
  };
  fill_durations(sample, timing_.interval());
  return sample;
}

}  // namespace sextant::ecu
