#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "ecu/shared/parameter_set.hpp"
#include "ecu/timing/wake_record.hpp"
#include "sextant/comms/command_receiver.hpp"
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

/// The shared state of the live drive's threads: all data that one thread passes to another. No member blocks
/// or locks.
struct SharedState {
  /// For a control period [ns], control periods a wake-up [-], and the watchdog's timeout [ns]. The rings
  /// have room for a second: a telemetry thread that stops for less loses nothing.
  SharedState(std::int32_t period_ns, int wake_every_periods,
              std::int64_t watchdog_ns = RealtimeParameters{}.watchdog_ns)
      : telemetry{a_second_of(period_ns)},
        stages{a_second_of(period_ns)},
        wakes{a_second_of(std::int64_t{period_ns} * wake_every_periods)},
        watchdog_ns_{watchdog_ns} {}

  /// Heartbeat of the control thread. After a gap beyond the timeout it sets the gate inhibit itself: the
  /// watchdog does not see a gap in which the whole process was stopped.
  void beat(std::int64_t woken_ns) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t before_ns = heartbeat_ns.exchange(woken_ns, std::memory_order_acq_rel);
    if (is_timeout(before_ns, woken_ns)) gate_inhibit.store(true, std::memory_order_release);
  }

  /// True while the last wake-up of the control thread is older than the timeout: `status_of_timed_out_drive`
  /// then replaces its status. A result of true also sets the gate inhibit, so that the drive is in the
  /// reported FAULT when its thread runs again. False before the first heartbeat and after the shutdown.
  /// `now_ns` on CLOCK_MONOTONIC [ns].
  [[nodiscard]] bool control_timed_out(std::int64_t now_ns) noexcept {
    if (stopped.load(std::memory_order_acquire)) return false;
    if (!is_timeout(heartbeat_ns.load(std::memory_order_acquire), now_ns)) return false;
    gate_inhibit.store(true, std::memory_order_release);
    return true;
  }

  /// Control periods that are in no published interval, since start: the ring or the publisher had no room.
  /// [-]
  [[nodiscard]] std::uint64_t dropped_periods() const noexcept {
    return telemetry.dropped() + unpublished_periods.load(std::memory_order_relaxed);
  }

  LatestValue<TorqueCommand<double>> command{};  ///< receive → control
  LatestValue<ParameterSet> parameters{};        ///< link → control: the next one once it is answered
  LatestValue<Telemetry<double>> status{};       ///< control → transmit
  LatestValue<RealTimeReport> real_time{};       ///< telemetry → transmit
  LatestValue<SchedulerSample> scheduler{};      ///< housekeeping → telemetry, since start
  Ring<Telemetry<double>> telemetry;             ///< control → telemetry
  Ring<StageRecord> stages;                      ///< control → telemetry
  Ring<WakeRecord> wakes;                        ///< control → telemetry
  std::atomic<int> control_thread_id{0};         ///< control → housekeeping, as the kernel has it
  std::atomic<std::int64_t> heartbeat_ns{0};  ///< control → watchdog, transmit, telemetry: last wake-up [ns]
  /// receive → telemetry: received frames by their `FrameVerdict` [-]
  std::array<std::atomic<std::uint64_t>, frame_verdict_count> frames{};
  std::atomic<std::int64_t> other_drive_ns{0};  ///< receive → control: last frame of another drive [ns]
  /// transmit → control: last status frame sent, or start of sending; below zero: before it [ns]
  std::atomic<std::int64_t> status_sent_ns{-1};
  std::atomic<std::uint64_t> unpublished_periods{0};  ///< of intervals that the publisher did not receive [-]
  std::atomic<std::uint64_t> telemetry_polls{0};      ///< telemetry → housekeeping: its polls so far [-]
  std::atomic<std::uint64_t> telemetry_stalls{0};     ///< housekeeping → main: stops of that thread [-]
  std::atomic<std::uint64_t> watchdog_polls{0};       ///< watchdog → housekeeping: its polls so far [-]
  std::atomic<std::uint64_t> housekeeping_polls{0};   ///< housekeeping → telemetry: its polls so far [-]
  std::atomic<std::uint64_t> parameters_answered{0};  ///< control → link: number of the last set [-]
  std::atomic<std::uint64_t> parameter_sets{0};       ///< control → link, telemetry: taken since start [-]
  std::atomic<bool> watchdog_stopped{false};  ///< housekeeping → control: no watchdog runs, which is a fault
  std::atomic<bool> gate_inhibit{false};      ///< watchdog, transmit, telemetry → control, which clears it
  static_assert(std::atomic<std::optional<Fault>>::is_always_lock_free);
  std::atomic<std::optional<Fault>>
      fault{};                        ///< control → watchdog: the first one, while the drive is in FAULT
  std::atomic<bool> shutdown{false};  ///< main, watchdog → control: ramp to zero and stop
  std::atomic<bool> stopped{false};   ///< control → all: the gates are off for good

 private:
  static std::size_t a_second_of(std::int64_t every_ns) { return std::size_t(ns_per_s / every_ns) + 1; }

  [[nodiscard]] bool is_timeout(std::int64_t begin_ns,
                                std::int64_t end_ns) const noexcept SEXTANT_NONBLOCKING {
    return begin_ns != 0 && end_ns - begin_ns > watchdog_ns_;
  }

  std::int64_t watchdog_ns_;
};

}  // namespace sextant::ecu
