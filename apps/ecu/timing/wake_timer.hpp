#pragma once

#include <cstdint>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/timing/command_probe.hpp"
#include "ecu/timing/stage_probe.hpp"
#include "ecu/timing/stamped_cycle.hpp"
#include "ecu/timing/wake_record.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant::ecu {

/// The statistics of the control thread, beside its loop: a WakeRecord of each wake-up and, through the ends
/// of the cycle with time stamps, a StageRecord of each control period. It belongs to the control thread.
class WakeTimer {
 public:
  /// Power stage, task and shared state are not owned and must outlive this object.
  WakeTimer(const RealtimeParameters& realtime, DriveIo<double>& io, ControlTask& task, SharedState& shared)
      : wake_every_periods_{realtime.wake_every_periods},
        shared_{shared},
        probe_{realtime.stage_statistics, realtime.gap_limit_ns},
        io_{io, probe_, command_probe_},
        commands_{task.commands(), probe_, command_probe_},
        telemetry_{task.telemetry(), probe_, shared.stages} {}
  WakeTimer(const WakeTimer&) = delete;
  WakeTimer& operator=(const WakeTimer&) = delete;

  /// The ends of the cycle, with time stamps around their calls.
  [[nodiscard]] StampedIo& io() noexcept { return io_; }
  [[nodiscard]] StampedCommands<SharedCommands>& commands() noexcept { return commands_; }
  [[nodiscard]] StampedTelemetry<SharedTelemetry>& telemetry() noexcept { return telemetry_; }

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
  StageProbe probe_;
  CommandProbe command_probe_{};
  StampedIo io_;
  StampedCommands<SharedCommands> commands_;
  StampedTelemetry<SharedTelemetry> telemetry_;
  WakeRecord record_{};
  std::int64_t woken_ns_{0};
  std::int64_t finished_ns_{0};
};

}  // namespace sextant::ecu
