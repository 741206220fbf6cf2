#pragma once

#include <cstdint>
#include <string>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/dds_telemetry.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/realtime/latency_histogram.hpp"

namespace sextant::ecu {

/// The telemetry thread: drains the rings, publishes intervals, state changes and statistics over DDS.
/// Whatever DDS does, the control thread never waits for it.
class TelemetryThread {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};             ///< control period [ns]
    std::uint32_t wake_every_periods{40};       ///< control periods a wake-up [-]
    std::uint32_t periods_per_sample{40};       ///< control periods in one DriveTelemetry [-]
    std::int64_t statistics_ns{1'000'000'000};  ///< between two RealTimeStatistics [ns]
    bool real_time_scheduling{false};           ///< SCHED_FIFO was granted
    bool memory_locked{false};
  };

  /// Totals of a run, for the report at the end.
  struct Totals {
    LatencyHistogram latency{};
    LatencyHistogram body{};
    WakeRecord last{};
  };

  TelemetryThread(const Parameters& parameters, DdsTelemetry& dds, Crossings& crossings)
      : parameters_{parameters}, dds_{dds}, crossings_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  [[nodiscard]] const Totals& totals() const noexcept { return totals_; }

 private:
  void run();
  void drain_telemetry();
  void drain_wakes();
  void publish_state(const Telemetry<double>& telemetry);
  void publish_statistics();
  void report_to_can();

  Parameters parameters_;
  DdsTelemetry& dds_;
  Crossings& crossings_;
  TelemetryInterval<double> interval_{};
  Telemetry<double> published_{};
  bool any_published_{false};
  LatencyHistogram latency_{};
  LatencyHistogram body_{};
  std::int64_t next_statistics_ns_{0};
  StatisticsReport report_{};
  std::int64_t next_report_ns_{0};
  Totals totals_{};
  Worker worker_{"sextant-dds"};
};

/// Why the drive is where it is, for people. At most 64 characters.
[[nodiscard]] std::string reason_for(const Telemetry<double>& telemetry);

}  // namespace sextant::ecu
