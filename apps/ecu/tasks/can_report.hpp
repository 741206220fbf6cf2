#pragma once

#include <algorithm>
#include <cstdint>

#include "ecu/shared/shared_state.hpp"

namespace sextant::ecu {

/// Collects MCU_RealTime from the wake-ups and stores it for the transmit thread once a second, independently
/// of the rate of RealTimeStatistics.
class CanReport {
 public:
  /// The shared state is not owned and must outlive this object.
  explicit CanReport(SharedState& shared) noexcept : shared_{shared} {}

  /// The first second begins. [ns]
  void start(std::int64_t t_ns) noexcept { next_ns_ = t_ns + ns_per_s; }

  void add(const WakeRecord& wake) {
    worst_execution_ns_ = std::max(worst_execution_ns_, wake.execution_ns);
    worst_latency_ns_ = std::max(worst_latency_ns_, wake.latency_ns);
    if (wake.deadline_ns >= next_ns_) hand_over(wake);
  }

  /// Stores the report since the last call; `wake` is the newest wake-up.
  void hand_over(const WakeRecord& wake) {
    shared_.real_time.store({.periods_missed = wake.periods_missed,
                             .worst_execution_time = double(worst_execution_ns_) * 1e-9,
                             .worst_wake_latency = double(worst_latency_ns_) * 1e-9,
                             .telemetry_dropped = shared_.dropped_periods()});
    worst_execution_ns_ = 0;
    worst_latency_ns_ = 0;
    next_ns_ = wake.deadline_ns + ns_per_s;
  }

 private:
  SharedState& shared_;
  std::int64_t worst_execution_ns_{0};
  std::int64_t worst_latency_ns_{0};
  std::int64_t next_ns_{0};
};

}  // namespace sextant::ecu
