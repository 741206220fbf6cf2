#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "sextant/core/drive_state.hpp"
#include "sextant/core/fault.hpp"

namespace sextant {

/// A sample of `DriveState` in configs/interfaces/telemetry.idl, but for what the writer adds (drive_id,
/// sequence).
struct DriveStateSample {
  std::int64_t t_ns{};  ///< when the state was entered, on the drive's clock [ns]
  DriveState state{DriveState::init};
  bool lockout{true};                  ///< a valid disable has yet to be seen
  FaultSet active{};                   ///< faults present
  FaultSet latched{};                  ///< faults since the last reset
  std::optional<Fault> first_fault{};  ///< the first that latched; empty for none
  std::uint32_t fault_total{};         ///< latched faults since start [-]
  std::string_view reason{};           ///< why the drive is where it is; the first 64 bytes are published
};

/// A sample of `RealTimeStatistics`, but for what the writer adds.
struct RealTimeSample {
  std::int64_t t_ns{};                 ///< end of the interval reported, on the drive's clock [ns]
  std::uint32_t period_ns{};           ///< control period [ns]
  std::uint32_t wake_every_periods{};  ///< control periods a wake-up [-]
  std::uint64_t periods{};             ///< run since start [-]
  std::uint64_t periods_skipped{};     ///< control periods missed since start [-]
  std::uint64_t overruns{};            ///< late wake-ups since start [-]
  double wake_latency_p50_us{};        ///< over the interval [µs]
  double wake_latency_p99_us{};        ///< [µs]
  double wake_latency_max_us{};        ///< [µs]
  double body_p50_us{};                ///< work of one wake-up, over the interval [µs]
  double body_p99_us{};                ///< [µs]
  double body_max_us{};                ///< [µs]
  std::uint64_t telemetry_dropped{};   ///< control periods lost to a full ring since start [-]
  std::uint64_t commands_received{};   ///< accepted frames since start [-]
  std::uint64_t commands_rejected{};   ///< dropped frames since start [-]
  bool real_time_scheduling{false};    ///< SCHED_FIFO was granted
  bool memory_locked{false};
};

}  // namespace sextant
