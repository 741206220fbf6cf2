#pragma once

#include <cstdint>
#include <future>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The newest command, and what the rest of the process demands. The watchdog's order is taken, not only
/// read, so that it cannot be withdrawn before the drive has seen it. Another drive on the bus is a fault for
/// as long as it is heard, and for `other_drive_hold_ns` more.
class LiveCommands {
 public:
  static constexpr std::int64_t other_drive_hold_ns = ns_per_s;  ///< [ns]

  explicit LiveCommands(Crossings& crossings) noexcept : crossings_{crossings} {}

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    DriveRequest<double> request{
        crossings_.command.latest(), crossings_.shutdown.load(std::memory_order_acquire), {}};
    const bool disabled = crossings_.gates_disabled.load(std::memory_order_relaxed) &&
                          crossings_.gates_disabled.exchange(false, std::memory_order_acq_rel);
    if (disabled) request.external.set(Fault::watchdog);
    const std::int64_t heard_ns = crossings_.other_drive_ns.load(std::memory_order_relaxed);
    if (heard_ns != 0 && t_ns - heard_ns < other_drive_hold_ns) request.external.set(Fault::second_master);
    return request;
  }

 private:
  Crossings& crossings_;
};

/// Hands telemetry to its thread; a full ring drops and counts.
class LiveTelemetry {
 public:
  explicit LiveTelemetry(Crossings& crossings) noexcept : crossings_{crossings} {}

  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING {
    last_ = telemetry;
    crossings_.telemetry.push(telemetry);
  }
  [[nodiscard]] const Telemetry<double>& last() const noexcept { return last_; }

 private:
  Crossings& crossings_;
  Telemetry<double> last_{};
};

/// The control thread: wakes on absolute deadlines, runs the control periods that are due, and stops once the
/// drive has shut down. Its body allocates, locks, throws, logs and blocks never.
class ControlThread {
 public:
  ControlThread(const RealtimeParameters& realtime, std::int32_t period_ns, DriveIo<double>& io,
                Drive<double>& drive, Crossings& crossings);

  /// Starts the thread and waits until it has asked for its rights; returns what it was given. The thread
  /// then sleeps until go(), so that whoever judges the rights is not starved by it.
  [[nodiscard]] RightsReport start();
  /// Lets the control periods begin; once.
  void go() { answer(true); }
  /// A thread that was never let go leaves without a period.
  void join();

 private:
  void run(std::future<bool> may_go);
  void answer(bool may_go);
  void wake_up(const WakeSchedule::Wake& wake) noexcept;
  /// What the time stamps tell of the way to this wake-up.
  [[nodiscard]] WakeRecord record_of(const WakeSchedule::Wake& wake) noexcept;
  /// The control periods of one wake-up, from its deadline on.
  void run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING;

  RealtimeParameters realtime_;
  std::int32_t period_ns_;
  StageProbe probe_;
  CommandProbe command_probe_{};
  StampedIo io_;
  Drive<double>& drive_;
  Crossings& crossings_;
  LiveCommands commands_;
  LiveTelemetry telemetry_;
  StampedCommands<LiveCommands> stamped_commands_;
  StampedTelemetry<LiveTelemetry> stamped_telemetry_;
  PeriodicTask task_;
  std::uint64_t periods_{0};
  std::int64_t finished_ns_{0};
  // Of this object, which outlives the thread: who sets a value may still be at it when another has it.
  std::promise<RightsReport> rights_{};
  std::promise<bool> go_{};
  bool answered_{false};
  Worker worker_{"sextant-control"};
};

}  // namespace sextant::ecu
