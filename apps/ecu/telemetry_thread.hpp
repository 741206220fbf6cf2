#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "ecu/can_report.hpp"
#include "ecu/crossings.hpp"
#include "ecu/telemetry_sender.hpp"
#include "ecu/timing_statistics.hpp"
#include "ecu/worker.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant::ecu {

/// The telemetry thread: drains the rings and hands intervals, state changes and statistics to the process
/// that publishes them. While the control thread is silent it says so in the place of the drive.
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

  /// `look` is called from this thread, every millisecond, with the time [ns]: it looks after the process.
  TelemetryThread(
      const Parameters& parameters, TelemetrySender& sender, Crossings& crossings,
      std::function<void(std::int64_t)> look = [](std::int64_t) {})
      : parameters_{parameters},
        sender_{sender},
        crossings_{crossings},
        look_{std::move(look)},
        timing_{parameters.timing},
        report_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// Of the run; for after the join.
  [[nodiscard]] const TimingStatistics& timing() const noexcept { return timing_; }
  /// The body of the loop at now_ns.
  void look(std::int64_t now_ns);

 private:
  void run();
  void drain_telemetry();
  void drain_wakes();
  void publish_state(const Telemetry<double>& telemetry);
  void publish_state(const Telemetry<double>& telemetry, const std::string& reason);
  void watch_control_thread(std::int64_t now_ns);
  void publish_statistics();
  [[nodiscard]] RealTimeSample sample() const;

  Parameters parameters_;
  TelemetrySender& sender_;
  Crossings& crossings_;
  std::function<void(std::int64_t)> look_;
  TelemetryInterval<double> interval_{};
  Telemetry<double> newest_{};     // of the drive
  Telemetry<double> published_{};  // as DriveState
  bool any_published_{false};
  std::int64_t next_silence_ns_{0};  // when to tell of it again
  TimingStatistics timing_;
  std::int64_t next_statistics_ns_{0};
  CanReport report_;
  Worker worker_{"sextant-dds"};
};

/// Why the drive is where it is, for people. At most 64 characters.
[[nodiscard]] std::string reason_for(const Telemetry<double>& telemetry);

}  // namespace sextant::ecu
