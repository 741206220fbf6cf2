#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "ecu/stage_probe.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/realtime/latest_value.hpp"
#include "sextant/realtime/miss.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/ring.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// One wake-up of the control thread, for the statistics.
struct WakeRecord {
  std::int64_t deadline_ns{};          ///< the deadline it served [ns]
  std::int64_t latency_ns{};           ///< from the deadline slept for to the wake-up [ns]
  std::int64_t body_ns{};              ///< work done in it [ns]
  std::uint64_t periods{};             ///< control periods run since start [-]
  std::uint64_t periods_skipped{};     ///< control periods missed since start [-]
  std::uint64_t overruns{};            ///< late wake-ups since start [-]
  bool overrun{false};                 ///< this one is such
  bool body_overran{false};            ///< the work before it ended after the deadline slept for
  Gap gap{};                           ///< what can have made it late
  std::int64_t longest_gap_ns{};       ///< the longest time between two time stamps since the one before [ns]
  std::int64_t command_to_gate_ns{0};  ///< from a new command's arrival to its first pattern; 0: none [ns]
};

/// What the transmit thread needs of the statistics.
struct StatisticsReport {
  std::uint64_t periods_skipped{};    ///< since start [-]
  std::int64_t worst_body_ns{};       ///< over the last second [ns]
  std::int64_t worst_latency_ns{};    ///< over the last second [ns]
  std::uint64_t telemetry_dropped{};  ///< since start [-]
};

/// Every place at which the threads of the live drive meet. Nothing here blocks or locks.
struct Crossings {
  /// For a control period [ns], so many of them a wake-up [-], and the longest time that the control thread
  /// may be silent [ns]. The rings have room for a second: a telemetry thread that is held up for less loses
  /// nothing.
  Crossings(std::int32_t period_ns, int wake_every_periods,
            std::int64_t silence_limit_ns = RealtimeParameters{}.watchdog_ns)
      : telemetry{a_second_of(period_ns)},
        stages{a_second_of(period_ns)},
        wakes{a_second_of(std::int64_t{period_ns} * wake_every_periods)},
        silence_limit_ns_{silence_limit_ns} {}

  /// The control thread's heartbeat. After an absence beyond the limit it orders the gates off itself: where
  /// everything stood still, nobody else has seen it.
  void beat(std::int64_t woken_ns) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t before_ns = heartbeat_ns.exchange(woken_ns, std::memory_order_acq_rel);
    if (is_silence(before_ns, woken_ns)) gates_disabled.store(true, std::memory_order_release);
  }

  /// True while the control thread has not woken up for longer than the limit: what it said last is then no
  /// longer true; `status_of_silent_drive` tells what is. Whoever learns it has ordered the gates
  /// off, so that a drive that comes back is the one in FAULT that the others were told of. False before the
  /// first heartbeat and after the shutdown. `now_ns` on CLOCK_MONOTONIC [ns].
  [[nodiscard]] bool control_silent(std::int64_t now_ns) noexcept {
    if (stopped.load(std::memory_order_acquire)) return false;
    if (!is_silence(heartbeat_ns.load(std::memory_order_acquire), now_ns)) return false;
    gates_disabled.store(true, std::memory_order_release);
    return true;
  }

  LatestValue<TorqueCommand<double>> command{};     ///< receive thread → control thread
  LatestValue<Telemetry<double>> status{};          ///< control thread → transmit thread
  LatestValue<StatisticsReport> statistics{};       ///< telemetry thread → transmit thread
  LatestValue<SchedulerSample> scheduler{};         ///< housekeeping → telemetry thread, since start
  Ring<Telemetry<double>> telemetry;                ///< control thread → telemetry thread
  Ring<StageRecord> stages;                         ///< control thread → telemetry thread
  Ring<WakeRecord> wakes;                           ///< control thread → telemetry thread
  std::atomic<int> control_thread_id{0};            ///< control thread → housekeeping, as the kernel has it
  std::atomic<std::int64_t> heartbeat_ns{0};        ///< control thread's last wake-up → watchdog [ns]
  std::atomic<std::uint64_t> commands_accepted{0};  ///< receive thread → telemetry thread [-]
  std::atomic<std::uint64_t> commands_rejected{0};  ///< receive thread → telemetry thread [-]
  std::atomic<std::int64_t> other_drive_ns{
      0};                                   ///< receive → control thread: last heard of another drive [ns]
  std::atomic<bool> gates_disabled{false};  ///< of a silent control thread; it takes the order
  std::atomic<bool> shutdown{false};        ///< main → control thread: ramp down and stop
  std::atomic<bool> stopped{false};         ///< control thread → all: the gates are off for good

 private:
  static std::size_t a_second_of(std::int64_t every_ns) { return std::size_t(ns_per_s / every_ns) + 1; }

  [[nodiscard]] bool is_silence(std::int64_t begin_ns,
                                std::int64_t end_ns) const noexcept SEXTANT_NONBLOCKING {
    return begin_ns != 0 && end_ns - begin_ns > silence_limit_ns_;
  }

  std::int64_t silence_limit_ns_;
};

}  // namespace sextant::ecu
