#include "ecu/tasks/telemetry_task.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "ecu/tasks/timed_out_drive.hpp"
#include "ecu/timing/microseconds.hpp"

namespace sextant::ecu {
namespace {

constexpr double zero_celsius_k = 273.15;

bool same_state(const Telemetry<double>& a, const Telemetry<double>& b) {
  const auto ramp = [](DeratingCause cause) { return is_ramp_to_zero(cause) ? cause : DeratingCause::none; };
  return a.state == b.state && a.lockout == b.lockout && a.active == b.active && a.latched == b.latched &&
         ramp(a.derating_cause) == ramp(b.derating_cause);
}

void fill_durations(RealTimeSample& sample, const TimingHistograms& histograms) {
  const LatencySummary latency = histograms.latency.summary();
  sample.wake_latency_p50_us = microseconds(latency.p50_ns);
  sample.wake_latency_p99_us = microseconds(latency.p99_ns);
  sample.wake_latency_p99_9_us = microseconds(latency.p99_9_ns);
  sample.wake_latency_p99_99_us = microseconds(latency.p99_99_ns);
  sample.wake_latency_max_us = microseconds(latency.max_ns);
  const LatencySummary execution = histograms.execution.summary();
  sample.execution_p50_us = microseconds(execution.p50_ns);
  sample.execution_p99_us = microseconds(execution.p99_ns);
  sample.execution_p99_9_us = microseconds(execution.p99_9_ns);
  sample.execution_p99_99_us = microseconds(execution.p99_99_ns);
  sample.execution_max_us = microseconds(execution.max_ns);
}

void fill_stages(RealTimeSample& sample, const TimingHistograms& histograms) {
  const auto fill = [&histograms](Stage stage, double& p50_us, double& p99_9_us, double& max_us) {
    const LatencySummary summary = histograms.stages[static_cast<std::size_t>(stage)].summary();
    p50_us = microseconds(summary.p50_ns);
    p99_9_us = microseconds(summary.p99_9_ns);
    max_us = microseconds(summary.max_ns);
  };
  static_assert(stage_count == 5);
  fill(Stage::read, sample.read_p50_us, sample.read_p99_9_us, sample.read_max_us);
  fill(Stage::commands, sample.commands_p50_us, sample.commands_p99_9_us, sample.commands_max_us);
  fill(Stage::drive, sample.drive_p50_us, sample.drive_p99_9_us, sample.drive_max_us);
  fill(Stage::write, sample.write_p50_us, sample.write_p99_9_us, sample.write_max_us);
  fill(Stage::push, sample.push_p50_us, sample.push_p99_9_us, sample.push_max_us);
}

/// Rejected frames by cause, and their sum.
void fill_rejections(RealTimeSample& sample, const SharedState& shared) {
  using Sample = RealTimeSample;
  constexpr auto first = std::size_t(FrameVerdict::not_valid_yet);
  constexpr auto causes = std::to_array<std::uint64_t Sample::*>(
      {&Sample::rejected_not_valid_yet, &Sample::rejected_wrong_length, &Sample::rejected_remote_frame,
       &Sample::rejected_extended_alias, &Sample::rejected_fd_alias, &Sample::rejected_wrong_crc,
       &Sample::rejected_wrong_data_id, &Sample::rejected_invalid_counter, &Sample::rejected_repeated,
       &Sample::rejected_wrong_sequence, &Sample::rejected_out_of_range});
  static_assert(causes.size() == frame_verdict_count - first);
  for (std::size_t k = 0; k < causes.size(); ++k) {
    const std::uint64_t count = shared.frames[first + k].load(std::memory_order_relaxed);
    sample.*causes[k] = count;
    sample.commands_rejected += count;
  }
}

/// Why torque is made and is not what is requested.
const char* reason_for(DeratingCause cause) {
  switch (cause) {
    case DeratingCause::command_timeout:
      return "ramp to zero: no command within command.timeout_ms";
    case DeratingCause::status_timeout:
      return "ramp to zero: the bus has taken no status frame within command.status_timeout_ms";
    case DeratingCause::shutdown:
      return "ramp to zero: shutting down";
    default:
      return "torque reference as requested";
  }
}

/// Why torque is made and less is available than requested.
const char* limit_of(DeratingCause cause) {
  switch (cause) {
    case DeratingCause::temperature:
      return "torque below the request: the winding is hot";
    case DeratingCause::dc_link_low:
      return "torque below the request: the link voltage is low";
    case DeratingCause::dc_link_high:
      return "torque below the request: the link voltage is high";
    default:
      return "torque below the request: less is available";
  }
}

}  // namespace

std::string reason_for(const Telemetry<double>& t) {
  switch (t.state) {
    case DriveState::init:
      return "waiting for the first valid measurement";
    case DriveState::standby:
      if (t.command_sequence == 0) return "no valid command yet";
      if (t.lockout) return "locked out until a valid disable";
      return t.derating_cause == DeratingCause::dc_link_low
                 ? "waiting for the DC link, whose voltage is below capability.ready_voltage_v"
                 : "getting ready";
    case DriveState::ready:
      return t.torque_motoring == 0.0 && t.torque_regenerating == 0.0
                 ? "no torque available at this speed and link voltage"
                 : "waiting for enable";
    case DriveState::magnetising:
      return "building up flux";
    case DriveState::torque:
      return reason_for(t.derating_cause);
    case DriveState::derated:
      if (is_ramp_to_zero(t.derating_cause)) return reason_for(t.derating_cause);
      return t.torque_reached == t.torque_reference ? limit_of(t.derating_cause)
                                                    : "the link voltage holds the torque off its reference";
    case DriveState::fault:
      return std::string{to_string(t.first_fault)} + ": reset, then disable, then enable";
    case DriveState::shutdown:
      return "shut down";
  }
  return "";
}

void TelemetryTask::start(std::int64_t now_ns, const RightsReport& rights) {
  real_time_scheduling_ = rights.real_time_scheduling;
  memory_locked_ = rights.memory_locked;
  next_statistics_ns_ = now_ns + parameters_.statistics_ns;
  report_.start(now_ns);
}

void TelemetryTask::poll(std::int64_t now_ns) {
  drain_telemetry();
  drain_wakes();
  publish_timeout(now_ns);
  shared_.telemetry_polls.fetch_add(1, std::memory_order_relaxed);
  watch_housekeeping();
}

void TelemetryTask::watch_housekeeping() {
  switch (housekeeping_.step(shared_.housekeeping_polls.load(std::memory_order_relaxed))) {
    case ThreadWatch::Change::none:
      return;
    case ThreadWatch::Change::stopped:
      return log_("the housekeeping thread has stopped: nothing watches the watchdog, the drive goes on");
    case ThreadWatch::Change::resumed:
      return log_("the housekeeping thread runs again");
  }
}

void TelemetryTask::finish() {
  drain_telemetry();
  drain_wakes();
  publish_waveform();
  timing_.finish();
  publish_statistics();
  report_.hand_over(timing_.last());
}

void TelemetryTask::publish_timeout(std::int64_t now_ns) {
  constexpr std::int64_t repeat_ns = 50'000'000;
  if (!shared_.control_timed_out(now_ns)) {
    next_timeout_ns_ = now_ns;
    return;
  }
  if (now_ns < next_timeout_ns_) return;
  next_timeout_ns_ = now_ns + repeat_ns;
  const std::int64_t absence_ns = now_ns - shared_.heartbeat_ns.load(std::memory_order_acquire);
  publish_state(status_of_timed_out_drive(newest_),
                fmt::format("WATCHDOG: control thread without a wake-up for {} ms", absence_ns / 1'000'000));
  any_published_ = false;  // the drive's next record is published in any case
}

void TelemetryTask::drain_telemetry() {
  shared_.unpublished_periods.store(sender_.dropped_periods(), std::memory_order_relaxed);
  Telemetry<double> telemetry;
  while (shared_.telemetry.pop(telemetry)) {
    newest_ = telemetry;
    interval_.add(telemetry);
    record_waveform(telemetry);
    if (!any_published_ || !same_state(telemetry, published_)) {
      log_state(telemetry);
      publish_state(telemetry, reason_for(telemetry));
    }
    if (interval_.count() < parameters_.periods_per_sample) continue;
    sender_.write(interval_.record(), shared_.dropped_periods());
    interval_.reset();
  }
}

void TelemetryTask::record_waveform(const Telemetry<double>& telemetry) {
  if (!sender_.waveform_is_read()) {
    waveform_.reset();
    return;
  }
  if (!waveform_.fits(telemetry)) publish_waveform();
  waveform_.add(telemetry);
}

void TelemetryTask::publish_waveform() {
  if (waveform_.is_empty()) return;
  sender_.write(waveform_.batch(), shared_.telemetry.dropped());
  waveform_.reset();
}

void TelemetryTask::log_state(const Telemetry<double>& telemetry) const {
  const bool ramps = is_ramp_to_zero(telemetry.derating_cause) && !is_ramp_to_zero(published_.derating_cause);
  const bool trips = telemetry.state == DriveState::fault && published_.state != DriveState::fault;
  if (ramps || trips) log_(fmt::format("{}: {}", to_string(telemetry.state), reason_for(telemetry)));
}

void TelemetryTask::publish_state(const Telemetry<double>& telemetry, const std::string& reason) {
  DriveStateSample sample{
      telemetry.t_ns,        telemetry.state, telemetry.lockout, telemetry.active, telemetry.latched, {},
      telemetry.fault_total, reason};
  if (telemetry.latched.any()) sample.first_fault = telemetry.first_fault;
  sender_.write(sample);
  published_ = telemetry;
  any_published_ = true;
}

void TelemetryTask::drain_wakes() {
  // The sample is read before the wake-ups and added after them: every overrun that ended before the sample
  // is then in the ring. One whose execution still runs is explained by the rest of the sample's growth.
  const bool sampled = shared_.scheduler.update();
  StageRecord stages;
  while (shared_.stages.pop(stages)) timing_.add(stages);
  WakeRecord wake;
  while (shared_.wakes.pop(wake)) {
    timing_.add(wake);
    report_.add(wake);
    if (wake.deadline_ns >= next_statistics_ns_) publish_statistics();
  }
  if (sampled) timing_.add(shared_.scheduler.value());
}

void TelemetryTask::publish_statistics() {
  sender_.write(sample());
  timing_.reset_interval();
  next_statistics_ns_ = timing_.last().deadline_ns + parameters_.statistics_ns;
}

RealTimeSample TelemetryTask::sample() const {
  const WakeRecord& last = timing_.last();
  const SchedulerSample& scheduler = timing_.scheduler();
  static_assert(overrun_cause_count == 4);
  const auto overruns = [this](OverrunCause cause) {
    return timing_.causes()[static_cast<std::size_t>(cause)];
  };
  RealTimeSample sample{
      .t_ns = last.deadline_ns,
      .period_ns = std::uint32_t(parameters_.period_ns),
      .wake_every_periods = parameters_.wake_every_periods,
      .wait = parameters_.wait,
      .policy = parameters_.policy,
      .periods = last.periods,
      .periods_missed = last.periods_missed,
      .overruns = last.overruns,
      .overruns_machine = overruns(OverrunCause::machine_gap),
      .overruns_stage_gap = overruns(OverrunCause::stage_gap),
      .overruns_late_wake = overruns(OverrunCause::late_wake),
      .overruns_own_execution = overruns(OverrunCause::long_execution),
      .overruns_without_gap = timing_.without_gap(),
      .gaps = timing_.gaps(),
      .longest_gap_us = microseconds(timing_.interval().longest_gap_ns),
      .page_faults = scheduler.minor_faults + scheduler.major_faults,
      .voluntary_switches = scheduler.voluntary_switches,
      .involuntary_switches = scheduler.involuntary_switches,
      .run_delay_us = microseconds(scheduler.run_delay_ns),
      .steal_us = microseconds(scheduler.steal_ns),
      .telemetry_dropped = shared_.dropped_periods(),
      .commands_received =
          shared_.frames[std::size_t(FrameVerdict::accepted)].load(std::memory_order_relaxed),
      .real_time_scheduling = real_time_scheduling_,
      .memory_locked = memory_locked_,
      .r_s_ohm = newest_.r_s,
      .r_r_ohm = newest_.r_r,
      .l_m_h = newest_.l_m,
      .r_s_deviation = newest_.r_s_deviation,
      .r_r_deviation = newest_.r_r_deviation,
      .l_m_deviation = newest_.l_m_deviation,
      .periods_unchecked = newest_.unchecked_periods,
      .parameter_sets = shared_.parameter_sets.load(std::memory_order_relaxed),
  };
  if (newest_.winding_temperature)
    sample.winding_temperature_k = *newest_.winding_temperature + zero_celsius_k;
  fill_durations(sample, timing_.interval());
  fill_stages(sample, timing_.interval());
  fill_rejections(sample, shared_);
  return sample;
}

}  // namespace sextant::ecu
