#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "sextant/core/drive_state.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/realtime/overrun.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {

/// A sample of `DriveState` in configs/interfaces/telemetry.idl. The writer adds drive_id and sequence.
struct DriveStateSample {
  std::int64_t t_ns{};  ///< when the state was entered, on the drive's clock [ns]
  DriveState state{DriveState::init};
  bool lockout{true};                  ///< no enable is accepted before a valid disable
  FaultSet active{};                   ///< faults present
  FaultSet latched{};                  ///< faults since the last reset
  std::optional<Fault> first_fault{};  ///< the first that latched; empty for none
  std::uint32_t fault_total{};         ///< latched faults since start [-]
  std::string_view reason{};           ///< reason of the state, for people; the first 64 bytes are published
};

/// How long one stage of the control period took.
struct StageFigures {
  double p50_us{};    ///< [µs]
  double p99_9_us{};  ///< [µs]
  double max_us{};    ///< [µs]
};

/// A sample of `RealTimeStatistics`. The writer adds drive_id and sequence.
struct RealTimeSample {
  std::int64_t t_ns{};                 ///< end of the interval reported, on the drive's clock [ns]
  std::uint32_t period_ns{};           ///< control period [ns]
  std::uint32_t wake_every_periods{};  ///< control periods a wake-up [-]
  WaitMode wait{WaitMode::sleep};
  SchedulingPolicy policy{SchedulingPolicy::fifo};  ///< as requested; granted: see real_time_scheduling
  std::uint64_t periods{};                          ///< run since start [-]
  std::uint64_t periods_missed{};                   ///< control periods missed since start [-]
  std::uint64_t overruns{};                         ///< late wake-ups since start [-]
  std::array<std::uint64_t, overrun_cause_count>
      overruns_by_cause{};               ///< overruns since start by `OverrunCause` [-]
  std::uint64_t overruns_without_gap{};  ///< overruns for which no gap accounts, since start [-]
  std::uint64_t gaps{};                  ///< wake-ups since start with a gap before them, overruns or not [-]
  double longest_gap_us{};               ///< between two time stamps, over the interval [µs]
  double wake_latency_p50_us{};          ///< over the interval [µs]
  double wake_latency_p99_us{};          ///< [µs]
  double wake_latency_p99_9_us{};        ///< [µs]
  double wake_latency_p99_99_us{};       ///< [µs]
  double wake_latency_max_us{};          ///< [µs]
  double execution_p50_us{};             ///< of one wake-up, over the interval [µs]
  double execution_p99_us{};             ///< [µs]
  double execution_p99_9_us{};           ///< [µs]
  double execution_p99_99_us{};          ///< [µs]
  double execution_max_us{};             ///< [µs]
  std::array<StageFigures, stage_count> stages{};  ///< of one control period, over the interval, by `Stage`
  std::uint64_t page_faults{};           ///< of the control thread since start, without and with a disk [-]
  std::uint64_t voluntary_switches{};    ///< the thread yielded the processor, since start [-]
  std::uint64_t involuntary_switches{};  ///< the thread was preempted, since start [-]
  double run_delay_us{};                 ///< ready, but without a processor, since start [µs]
  double steal_us{};                     ///< of all CPUs by the hypervisor, since start [µs]
  std::uint64_t telemetry_dropped{};     ///< control periods lost to a full ring since start [-]
  std::uint64_t commands_received{};     ///< accepted frames since start [-]
  std::uint64_t commands_rejected{};     ///< dropped frames since start [-]
  bool real_time_scheduling{false};      ///< SCHED_FIFO or SCHED_DEADLINE was granted
  bool memory_locked{false};
};

}  // namespace sextant
