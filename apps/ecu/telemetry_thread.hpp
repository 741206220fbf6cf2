#pragma once

#include <cstdint>
#include <string>

#include "ecu/can_report.hpp"
#include "ecu/crossings.hpp"
#include "ecu/timing_statistics.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/dds_telemetry.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

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
    TimingStatistics::Parameters timing{};
    WaitMode wait{WaitMode::sleep};
    SchedulingPolicy policy{SchedulingPolicy::fifo};
    bool real_time_scheduling{false};  ///< SCHED_FIFO or SCHED_DEADLINE was granted
    bool memory_locked{false};
  };

  TelemetryThread(const Parameters& parameters, DdsTelemetry& dds, Crossings& crossings)
      : parameters_{parameters},
        dds_{dds},
        crossings_{crossings},
        timing_{parameters.timing},
        report_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// Of the run; for after the join.
  [[nodiscard]] const TimingStatistics& timing() const noexcept { return timing_; }

 private:
  void run();
  void drain_telemetry();
  void drain_wakes();
  void publish_state(const Telemetry<double>& telemetry);
  void publish_statistics();
  [[nodiscard]] RealTimeSample sample() const;

  Parameters parameters_;
  DdsTelemetry& dds_;
  Crossings& crossings_;
  TelemetryInterval<double> interval_{};
  Telemetry<double> published_{};
  bool any_published_{false};
  TimingStatistics timing_;
  std::int64_t next_statistics_ns_{0};
  CanReport report_;
  Worker worker_{"sextant-dds"};
};

/// Why the drive is where it is, for people. At most 64 characters.
[[nodiscard]] std::string reason_for(const Telemetry<double>& telemetry);

}  // namespace sextant::ecu
