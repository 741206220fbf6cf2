#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "ecu/timing/wake_record.hpp"
#include "sextant/comms/status_messages.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/realtime/latest_value.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/ring.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The shared state of the threads of the live drive: all that one of them hands to another. Nothing here
/// blocks or locks.
struct SharedState {
  /// For a control period [ns], so many of them a wake-up [-], and the watchdog's timeout [ns]. The rings
  /// have room for a second: a telemetry thread that is held up for less loses nothing.
  SharedState(std::int32_t period_ns, int wake_every_periods,
              std::int64_t watchdog_ns = RealtimeParameters{}.watchdog_ns)
      : telemetry{a_second_of(period_ns)},
        stages{a_second_of(period_ns)},
        wakes{a_second_of(std::int64_t{period_ns} * wake_every_periods)},
        watchdog_ns_{watchdog_ns} {}

  /// The control thread's heartbeat. After an absence beyond the timeout the control thread orders its own
  /// gates off: where the whole process stood still, no watchdog has seen it.
  void beat(std::int64_t woken_ns) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t before_ns = heartbeat_ns.exchange(woken_ns, std::memory_order_acq_rel);
    if (is_timeout(before_ns, woken_ns)) gate_inhibit.store(true, std::memory_order_release);
  }

  /// True while the control thread has not woken up for longer than the timeout: its last status is then no
  /// longer true, and `status_of_timed_out_drive` is. A caller that gets true has ordered the gates off, so
  /// that a drive that comes back is in the FAULT that was reported. False before the first heartbeat and
  /// after the shutdown. `now_ns` on CLOCK_MONOTONIC [ns].
  [[nodiscard]] bool control_timed_out(std::int64_t now_ns) noexcept {
    if (stopped.load(std::memory_order_acquire)) return false;
    if (!is_timeout(heartbeat_ns.load(std::memory_order_acquire), now_ns)) return false;
    gate_inhibit.store(true, std::memory_order_release);
    return true;
  }

  LatestValue<TorqueCommand<double>> command{};  ///< receive → control
  LatestValue<Telemetry<double>> status{};       ///< control → transmit
  LatestValue<RealTimeReport> real_time{};       ///< telemetry → transmit
  LatestValue<SchedulerSample> scheduler{};      ///< housekeeping → telemetry, since start
  Ring<Telemetry<double>> telemetry;             ///< control → telemetry
  Ring<StageRecord> stages;                      ///< control → telemetry
  Ring<WakeRecord> wakes;                        ///< control → telemetry
  std::atomic<int> control_thread_id{0};         ///< control → housekeeping, as the kernel has it
  std::atomic<std::int64_t> heartbeat_ns{0};  ///< control → watchdog, transmit, telemetry: last wake-up [ns]
  std::atomic<std::uint64_t> commands_accepted{0};  ///< receive → telemetry [-]
  std::atomic<std::uint64_t> commands_rejected{0};  ///< receive → telemetry [-]
  std::atomic<std::int64_t> other_drive_ns{0};      ///< receive → control: last frame of another drive [ns]
  std::atomic<bool> gate_inhibit{false};  ///< watchdog, transmit, telemetry → control, which takes the order
  std::atomic<bool> shutdown{false};      ///< main → control: ramp down and stop
  std::atomic<bool> stopped{false};       ///< control → all: the gates are off for good

 private:
  static std::size_t a_second_of(std::int64_t every_ns) { return std::size_t(ns_per_s / every_ns) + 1; }

  [[nodiscard]] bool is_timeout(std::int64_t begin_ns,
                                std::int64_t end_ns) const noexcept SEXTANT_NONBLOCKING {
    return begin_ns != 0 && end_ns - begin_ns > watchdog_ns_;
  }

  std::int64_t watchdog_ns_;
};

}  // namespace sextant::ecu
