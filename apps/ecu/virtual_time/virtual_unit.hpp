#pragma once

#include <cstdint>
#include <functional>

#include "ecu/tasks/can_report.hpp"
#include "ecu/unit/drive_unit.hpp"
#include "sextant/realtime/wake_schedule.hpp"
#include "sextant/virtual_time/late_wakes.hpp"
#include "sextant/virtual_time/run_recorder.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant::ecu {

/// A drive on a timeline: the tasks that threads run in the live program run here one after the other.
class VirtualUnit {
 public:
  /// What belongs to a drive. Nothing is owned; all must outlive this object.
  struct Parts {
    DriveUnit& unit;
    RunRecorder& recorder;
    LateWakes late_wakes{};
    /// Called with each control period that has run, before the next one reads the power stage; may be empty.
    std::function<void(const Telemetry<double>&)> observer{};
  };

  /// The grid of wake-ups begins at the clock's time.
  VirtualUnit(Parts parts, const VirtualClock& clock);
  VirtualUnit(const VirtualUnit&) = delete;
  VirtualUnit& operator=(const VirtualUnit&) = delete;

  /// Adds its tasks but reception: control, watchdog, transmission.
  void join(VirtualTimeline& timeline);

  void receive(const CanFrame& frame) { (void)unit_.receive().on_frame(frame); }
  /// A frame on the bus, which is this drive's while it transmits.
  void sent(const CanFrame& frame) {
    if (is_transmitting_) recorder_.add(frame, clock_.now_ns());
  }

  [[nodiscard]] const DriveUnit& unit() const noexcept { return unit_; }
  /// Torque to zero, gates off, stop; as SIGTERM in the live drive.
  void shut_down() noexcept { unit_.shut_down(); }
  /// False once the drive has shut down.
  [[nodiscard]] bool is_running() const noexcept {
    return !unit_.shared().stopped.load(std::memory_order_relaxed);
  }
  /// True once the drive has shut down and sent its last status.
  [[nodiscard]] bool stopped() const noexcept { return sent_last_; }
  /// The next control period; before the run the first one, a wake period after its begin. [ns]
  [[nodiscard]] std::int64_t next_period_ns() const noexcept { return schedule_.next_deadline_ns(); }

  /// The newest control period.
  [[nodiscard]] const Telemetry<double>& telemetry() const noexcept { return unit_.control().last(); }
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return unit_.receive().receiver(); }
  [[nodiscard]] const WakeSchedule::Counters& wakes() const noexcept { return schedule_.counters(); }
  /// Values beyond the range of their signals. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return unit_.transmit().clamped(); }

 private:
  [[nodiscard]] std::int64_t next_wake_ns() const noexcept {
    return late_wakes_.wake_ns(schedule_.next_deadline_ns());
  }
  void wake_up();
  void poll_watchdog();
  void transmit();

  const VirtualClock& clock_;
  DriveUnit& unit_;
  RunRecorder& recorder_;
  LateWakes late_wakes_;
  std::function<void(const Telemetry<double>&)> observer_;
  WakeSchedule schedule_;
  CanReport report_;
  std::int64_t next_watchdog_ns_;
  std::int64_t next_transmit_ns_;
  bool is_transmitting_{false};
  bool sent_last_{false};
};

}  // namespace sextant::ecu
