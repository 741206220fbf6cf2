#pragma once

#include <cstdint>

#include "ecu/shared/cycle_recorder.hpp"
#include "ecu/shared/shared_state.hpp"
#include "ecu/timing/command_probe.hpp"
#include "ecu/timing/stage_probe.hpp"
#include "ecu/timing/wake_record.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant::ecu {

/// The probe of the control thread's periods, and its statistics: a WakeRecord of each wake-up, a StageRecord
/// of each control period and, where the periods are recorded, their CycleRecord. It belongs to the control
/// thread.
class WakeTimer {
 public:
  /// Shared state and recorder are not owned and must outlive this object. `cycles`: nullptr for none.
  WakeTimer(const RealtimeParameters& realtime, SharedState& shared, CycleRecorder* cycles = nullptr)
      : wake_every_periods_{realtime.wake_every_periods},
        shared_{shared},
        cycles_{cycles},
        probe_{realtime.stage_statistics, realtime.gap_limit_ns} {}
  WakeTimer(const WakeTimer&) = delete;
  WakeTimer& operator=(const WakeTimer&) = delete;

  // The probe of `run_cycle`.

  void begins(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    probe_.begin();
    if (cycles_ != nullptr) cycles_->begins(t_ns);
  }
  void has_read(const Measurement<double>& measurement) noexcept SEXTANT_NONBLOCKING {
    if (cycles_ != nullptr) cycles_->has_read(measurement);
    probe_.end(Stage::read);
  }
  void has_request(const DriveRequest<double>& request) noexcept SEXTANT_NONBLOCKING {
    if (cycles_ != nullptr) cycles_->has_request(request);
    command_probe_.add(request.command);
    probe_.end(Stage::commands);
  }
  void has_stepped(const DriveOutput<double>& output) noexcept SEXTANT_NONBLOCKING {
    probe_.end(Stage::drive);
    if (cycles_ != nullptr) cycles_->has_stepped(output);
  }
  void has_written() noexcept SEXTANT_NONBLOCKING {
    if (cycles_ != nullptr) cycles_->has_written();
    command_probe_.written();
    probe_.end(Stage::write);
  }
  void has_pushed() noexcept SEXTANT_NONBLOCKING {
    probe_.end(Stage::push);
    if (probe_.on()) shared_.stages.push(probe_.record());
  }

  /// The grid of deadlines begins at origin_ns. [ns]
  void start(std::int64_t origin_ns) noexcept { finished_ns_ = origin_ns; }

  /// A wait has ended in this wake-up: evaluates the time stamps before it.
  void begin(const PeriodicTask& periodic, const WakeSchedule::Wake& wake) noexcept SEXTANT_NONBLOCKING {
    probe_.wake();
    woken_ns_ = periodic.woken_ns();
    probe_.add(periodic.began_ns() - finished_ns_, GapPlace::between);
    // After an execution that ended before the deadline only a gap in the wait can have made this wake-up
    // late.
    const bool execution_overran = periodic.began_ns() > woken_ns_ - wake.latency_ns;
    if (!execution_overran) probe_.clear_gap();
    probe_.add(periodic.longest_gap_ns(), GapPlace::waiting);
    const WakeSchedule::Counters& counters = periodic.schedule().counters();
    record_ = {.deadline_ns = wake.deadline_ns,
               .latency_ns = wake.latency_ns,
               .periods = record_.periods,
               .periods_missed = counters.periods_missed,
               .overruns = counters.overruns,
               .overrun = wake.overrun(),
               .execution_overran = execution_overran,
               .gap = probe_.gap(),
               .longest_gap_ns = probe_.take_longest_ns()};
    // Each gap explains one overrun.
    probe_.fade_gap(wake.overrun() ? 0 : wake.latency_ns);
  }

  /// The execution of the wake-up has ended at finished_ns [ns]: its record is queued for the telemetry
  /// thread.
  void end(std::int64_t finished_ns) noexcept SEXTANT_NONBLOCKING {
    finished_ns_ = finished_ns;
    record_.execution_ns = finished_ns - woken_ns_;
    record_.periods += std::uint64_t(wake_every_periods_);
    record_.command_to_gate_ns = command_probe_.take_longest_ns();
    probe_.finish(record_.execution_ns);
    shared_.wakes.push(record_);
  }

 private:
  int wake_every_periods_;
  SharedState& shared_;
  CycleRecorder* cycles_;
  StageProbe probe_;
  CommandProbe command_probe_{};
  WakeRecord record_{};
  std::int64_t woken_ns_{0};
  std::int64_t finished_ns_{0};
};

}  // namespace sextant::ecu
