#pragma once

#include <atomic>
#include <cstdint>

#include "ecu/shared_state.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant::ecu {

/// The requests of the cycle: the newest command, shutdown, and the faults that other threads detect. Only
/// this class clears the gate inhibit, when it passes it on, so that none is lost. Another drive on the bus
/// is a fault while its frames arrive, and for `other_drive_hold_ns` more.
class SharedCommands {
 public:
  static constexpr std::int64_t other_drive_hold_ns = ns_per_s;  ///< [ns]

  explicit SharedCommands(SharedState& shared) noexcept : shared_{shared} {}

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    DriveRequest<double> request{
        shared_.command.latest(), shared_.shutdown.load(std::memory_order_acquire), {}};
    const bool inhibit = shared_.gate_inhibit.load(std::memory_order_relaxed) &&
                         shared_.gate_inhibit.exchange(false, std::memory_order_acq_rel);
    if (inhibit) request.external.set(Fault::watchdog);
    const std::int64_t other_ns = shared_.other_drive_ns.load(std::memory_order_relaxed);
    if (other_ns != 0 && t_ns - other_ns < other_drive_hold_ns) request.external.set(Fault::second_master);
    return request;
  }

 private:
  SharedState& shared_;
};

/// The telemetry sink of the cycle: one record a period into the ring; a full ring drops and counts.
class SharedTelemetry {
 public:
  explicit SharedTelemetry(SharedState& shared) noexcept : shared_{shared} {}

  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING {
    last_ = telemetry;
    shared_.telemetry.push(telemetry);
  }
  [[nodiscard]] const Telemetry<double>& last() const noexcept SEXTANT_NONBLOCKING { return last_; }

 private:
  SharedState& shared_;
  Telemetry<double> last_{};
};

/// The work of the control thread, without the thread and its statistics. Reads no clock; never allocates,
/// locks, throws, logs or blocks.
class ControlTask {
 public:
  /// Drive and shared state are not owned and must outlive this object.
  ControlTask(const WakeSchedule::Parameters& wakes, Drive<double>& drive, SharedState& shared) noexcept
      : wakes_{wakes}, drive_{drive}, shared_{shared}, commands_{shared}, telemetry_{shared} {}

  /// A wake-up at woken_ns that serves deadline_ns [ns]: heartbeat, the control periods from the deadline on,
  /// the newest status. `commands` and `telemetry`: those of this object, or these with time stamps around
  /// their calls (stamped_cycle.hpp).
  template <class Commands, class TelemetrySink>
  void wake_up(std::int64_t woken_ns, std::int64_t deadline_ns, DriveIo<double>& io, Commands& commands,
               TelemetrySink& telemetry) noexcept SEXTANT_NONBLOCKING {
    shared_.beat(woken_ns);
    for (int n = 0; n < wakes_.wake_every_periods; ++n) {
      run_cycle(deadline_ns + std::int64_t{n} * wakes_.period_ns, io, commands, drive_, telemetry);
    }
    shared_.status.store(telemetry_.last());
  }

  [[nodiscard]] bool has_shut_down() const noexcept { return drive_.state() == DriveState::shutdown; }

  [[nodiscard]] SharedCommands& commands() noexcept { return commands_; }
  [[nodiscard]] SharedTelemetry& telemetry() noexcept { return telemetry_; }
  [[nodiscard]] const SharedTelemetry& telemetry() const noexcept { return telemetry_; }

 private:
  WakeSchedule::Parameters wakes_;
  Drive<double>& drive_;
  SharedState& shared_;
  SharedCommands commands_;
  SharedTelemetry telemetry_;
};

}  // namespace sextant::ecu
