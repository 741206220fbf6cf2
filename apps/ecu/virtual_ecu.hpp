#pragma once

#include <cstdint>

#include "ecu/can_receive_thread.hpp"
#include "ecu/can_report.hpp"
#include "ecu/can_transmit_thread.hpp"
#include "ecu/control_thread.hpp"
#include "ecu/crossings.hpp"
#include "ecu/watchdog_thread.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/harness/late_wakes.hpp"
#include "sextant/harness/run_recorder.hpp"
#include "sextant/harness/virtual_can_bus.hpp"
#include "sextant/harness/virtual_timeline.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/wake_schedule.hpp"

namespace sextant::ecu {

/// The live drive in virtual time: what its threads do at an instant, they do here one after the other,
/// through the same crossings. A frame is taken when it arrives; then the control periods of a wake-up run;
/// then the watchdog looks and status is sent. The work itself takes no virtual time; wake-ups come late
/// where `LateWakes` says so. What is left out of the live drive is threads, DDS and the machine's clock.
class VirtualEcu {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< control period [ns]
    RealtimeParameters realtime{};   ///< of it `wake_every_periods` and `watchdog_ns`
  };

  /// Clock, bus, power stage, drive and recorder are not owned and must outlive this object. The grid of
  /// wake-ups begins at the clock's time.
  VirtualEcu(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus, DriveIo<double>& io,
             Drive<double>& drive, RunRecorder& recorder, LateWakes late_wakes = {});
  VirtualEcu(const VirtualEcu&) = delete;
  VirtualEcu& operator=(const VirtualEcu&) = delete;

  /// Adds what stands for its threads: reception, control, watchdog, transmission.
  void join(VirtualTimeline& timeline);

  /// Torque to zero, gates off, stop; as SIGTERM asks of the live drive.
  void shut_down() noexcept { crossings_.shutdown.store(true, std::memory_order_release); }
  /// True once the drive has shut down and said so.
  [[nodiscard]] bool stopped() const noexcept { return said_last_; }

  /// The newest control period.
  [[nodiscard]] const Telemetry<double>& telemetry() const noexcept { return telemetry_.last(); }
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return receive_.receiver(); }
  [[nodiscard]] const WakeSchedule::Counters& wakes() const noexcept { return schedule_.counters(); }
  /// Values that did not fit into their signals. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return transmit_.clamped(); }

 private:
  [[nodiscard]] bool is_running() const noexcept {
    return !crossings_.stopped.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::int64_t next_wake_ns() const noexcept;
  void receive();
  void wake_up();
  void run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING;
  void drain();
  void transmit();

  Parameters parameters_;
  const VirtualClock& clock_;
  VirtualCanBus& bus_;
  DriveIo<double>& io_;
  Drive<double>& drive_;
  RunRecorder& recorder_;
  LateWakes late_wakes_;
  Crossings crossings_;
  CanReceiveThread receive_;
  CanTransmitThread transmit_;
  WatchdogThread watchdog_;
  LiveCommands commands_;
  LiveTelemetry telemetry_;
  WakeSchedule schedule_;
  CanReport report_;
  std::int64_t next_look_ns_;
  std::int64_t next_transmit_ns_;
  bool said_last_{false};
};

}  // namespace sextant::ecu
