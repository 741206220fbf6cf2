#pragma once

#include <array>
#include <cstdint>

#include "sextant/realtime/overrun.hpp"

namespace sextant::ecu {

/// How long the stages of one control period took. [ns]
using StageRecord = std::array<std::uint32_t, stage_count>;

/// One wake-up of the control thread, for the statistics.
struct WakeRecord {
  std::int64_t deadline_ns{};          ///< the deadline it served [ns]
  std::int64_t latency_ns{};           ///< from the deadline of the wait to the wake-up [ns]
  std::int64_t execution_ns{};         ///< its execution time [ns]
  std::uint64_t periods{};             ///< control periods run since start [-]
  std::uint64_t periods_missed{};      ///< control periods missed since start [-]
  std::uint64_t overruns{};            ///< overruns since start [-]
  bool overrun{false};                 ///< this one is an overrun
  bool execution_overran{false};       ///< the execution before it ended after that deadline
  Gap gap{};                           ///< the gaps that can have made it late
  std::int64_t longest_gap_ns{};       ///< the longest time between two time stamps since the one before [ns]
  std::int64_t command_to_gate_ns{0};  ///< from a new command's arrival to its first pattern; 0: none [ns]
};

}  // namespace sextant::ecu
