#pragma once

#include <algorithm>
#include <cstdint>

#include "ecu/crossings.hpp"

namespace sextant::ecu {

/// Gathers what MCU_RealTime tells and hands it to the transmit thread once a second, whatever the rate of
/// RealTimeStatistics.
class CanReport {
 public:
  /// The crossings are not owned and must outlive this object.
  explicit CanReport(Crossings& crossings) noexcept : crossings_{crossings} {}

  /// The first second begins. [ns]
  void start(std::int64_t t_ns) noexcept { next_ns_ = t_ns + ns_per_s; }

  void add(const WakeRecord& wake) {
    report_.worst_body_ns = std::max(report_.worst_body_ns, wake.body_ns);
    report_.worst_latency_ns = std::max(report_.worst_latency_ns, wake.latency_ns);
    if (wake.deadline_ns >= next_ns_) hand_over(wake);
  }

  /// Hands over what has come since the last time; `wake` is the newest wake-up.
  void hand_over(const WakeRecord& wake) {
    report_.periods_skipped = wake.periods_skipped;
    report_.telemetry_dropped = crossings_.telemetry.dropped();
    crossings_.statistics.store(report_);
    report_ = {};
    next_ns_ = wake.deadline_ns + ns_per_s;
  }

 private:
  Crossings& crossings_;
  StatisticsReport report_{};
  std::int64_t next_ns_{0};
};

}  // namespace sextant::ecu
