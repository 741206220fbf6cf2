#pragma once

#include <cstdint>
#include <optional>

#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/shared_commands.hpp"
#include "ecu/tasks/shared_telemetry.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant::ecu {

/// The work of the control thread, without the thread and its statistics. Reads no clock; never allocates,
/// locks, throws, logs or blocks.
class ControlTask {
 public:
  /// Drive and shared state are not owned and must outlive this object; so must a drive of
  /// `SharedState::parameters` once it runs. overrun_limit: overruns in a row that are a fault [-].
  ControlTask(const WakeSchedule::Parameters& wakes, Drive<double>& drive, SharedState& shared,
              std::uint32_t overrun_limit = RealtimeParameters{}.overrun_limit) noexcept
      : wakes_{wakes},
        drive_{&drive},
        shared_{shared},
        commands_{shared, overrun_limit},
        telemetry_{shared} {}

  /// A wake-up at woken_ns that serves deadline_ns [ns]: heartbeat, parameters that wait, the control periods
  /// from the deadline on, the newest status. `overruns_in_a_row`: of the schedule, this wake-up's included
  /// [-]. `probe`: of `run_cycle`.
  template <class Probe>
  void wake_up(std::int64_t woken_ns, std::int64_t deadline_ns, std::uint32_t overruns_in_a_row,
               DriveIo<double>& io, Probe& probe) noexcept SEXTANT_NONBLOCKING {
    shared_.beat(woken_ns);
    if (shared_.parameters.update()) take(shared_.parameters.value());
    commands_.note_overruns(overruns_in_a_row);
    for (int n = 0; n < wakes_.wake_every_periods; ++n) {
      run_cycle(deadline_ns + std::int64_t{n} * wakes_.period_ns, io, commands_, *drive_, telemetry_, probe);
    }
    const Telemetry<double>& last = telemetry_.last();
    shared_.status.store(last);
    const bool is_in_fault = last.state == DriveState::fault;
    shared_.fault.store(is_in_fault ? std::optional{last.first_fault} : std::nullopt,
                        std::memory_order_relaxed);
  }

  [[nodiscard]] bool has_shut_down() const noexcept { return drive_->state() == DriveState::shutdown; }

  [[nodiscard]] const WakeSchedule::Parameters& wakes() const noexcept { return wakes_; }
  /// The newest control period; for the thread that runs them.
  [[nodiscard]] const Telemetry<double>& last() const noexcept { return telemetry_.last(); }

 private:
  /// Takes parameters between two control periods, unless they have to wait for a drive at rest.
  void take(const ParameterSet& set) noexcept SEXTANT_NONBLOCKING {
    bool taken = true;
    if (set.changes == Changes::always) {
      drive_->take_parameters(*set.drive);
    } else if (drive_->is_at_rest()) {
      set.drive->continue_after(*drive_);
      drive_ = set.drive;
    } else {
      taken = false;
    }
    if (taken) shared_.parameter_sets.fetch_add(1, std::memory_order_relaxed);
    shared_.parameters_answered.store(set.number, std::memory_order_release);
  }

  WakeSchedule::Parameters wakes_;
  Drive<double>* drive_;  ///< that runs
  SharedState& shared_;
  SharedCommands commands_;
  SharedTelemetry telemetry_;
};

}  // namespace sextant::ecu
