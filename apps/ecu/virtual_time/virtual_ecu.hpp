#pragma once

#include <cstdint>
#include <functional>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/tasks/receive_task.hpp"
#include "ecu/tasks/transmit_task.hpp"
#include "ecu/tasks/watchdog_task.hpp"
#include "ecu/timing/can_report.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/harness/late_wakes.hpp"
#include "sextant/harness/run_recorder.hpp"
#include "sextant/harness/virtual_can_bus.hpp"
#include "sextant/harness/virtual_timeline.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant::ecu {

/// The live drive in virtual time: the tasks of its threads run one after the other, on the same shared
/// state, and no thread exists. A frame is received when it arrives; then the control periods of a wake-up
/// run; then the watchdog is polled and status is sent. Execution takes no virtual time; `LateWakes` lists
/// the late wake-ups. Threads, DDS and the machine's clock are left out.
class VirtualEcu {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< control period [ns]
    RealtimeParameters realtime{};   ///< of it `wake_every_periods`, `watchdog_ns` and `overrun_limit`
    IdentifierOffset identifier_offset{};
    CycleRecorder* cycles{nullptr};  ///< records the requests; not owned
    /// Called with each control period that has run, before the next one reads the power stage; may be empty.
    std::function<void(const Telemetry<double>&)> observer{};
  };

  /// Clock, bus, power stage, drive and recorder are not owned and must outlive this object. The grid of
  /// wake-ups begins at the clock's time.
  VirtualEcu(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus, DriveIo<double>& io,
             Drive<double>& drive, RunRecorder& recorder, LateWakes late_wakes = {});
  VirtualEcu(const VirtualEcu&) = delete;
  VirtualEcu& operator=(const VirtualEcu&) = delete;

  /// Adds its tasks: reception, control, watchdog, transmission.
  void join(VirtualTimeline& timeline);

  /// Torque to zero, gates off, stop; as SIGTERM in the live drive.
  void shut_down() noexcept { shared_.shutdown.store(true, std::memory_order_release); }
  /// True once the drive has shut down and sent its last status.
  [[nodiscard]] bool stopped() const noexcept { return sent_last_; }

  /// The next control period; before the run the first one, a wake period after its begin. [ns]
  [[nodiscard]] std::int64_t next_period_ns() const noexcept { return schedule_.next_deadline_ns(); }

  /// For who sets parameters while the drive runs.
  [[nodiscard]] SharedState& shared() noexcept { return shared_; }
  /// The newest control period.
  [[nodiscard]] const Telemetry<double>& telemetry() const noexcept { return control_.telemetry().last(); }
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return receive_.receiver(); }
  [[nodiscard]] const WakeSchedule::Counters& wakes() const noexcept { return schedule_.counters(); }
  /// Values beyond the range of their signals. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return transmit_.clamped(); }

 private:
  [[nodiscard]] bool is_running() const noexcept { return !shared_.stopped.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t next_wake_ns() const noexcept;
  void receive();
  void wake_up();
  void drain();
  void transmit();

  const VirtualClock& clock_;
  VirtualCanBus& bus_;
  DriveIo<double>& io_;
  RunRecorder& recorder_;
  LateWakes late_wakes_;
  std::function<void(const Telemetry<double>&)> observer_;
  WakeSchedule schedule_;
  SharedState shared_;
  ReceiveTask receive_;
  ControlTask control_;
  WatchdogTask watchdog_;
  TransmitTask transmit_;
  CanReport report_;
  std::int64_t next_watchdog_ns_;
  std::int64_t next_transmit_ns_;
  bool sent_last_{false};
};

}  // namespace sextant::ecu
