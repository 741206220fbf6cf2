#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/can_report.hpp"
#include "ecu/tasks/thread_watch.hpp"
#include "ecu/telemetry/telemetry_sender.hpp"
#include "ecu/timing/timing_statistics.hpp"
#include "sextant/comms/waveform_recorder.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The work of the telemetry thread, without the thread: drains the rings and sends intervals, state changes,
/// statistics and, while they are read, waveforms to the process that publishes them. While the control
/// thread has timed out the task publishes `status_of_timed_out_drive`. Reads no clock.
class TelemetryTask {
 public:
  static constexpr int poll_every_ms = 1;  ///< [ms]

  struct Parameters {
    std::int32_t period_ns{25'000};             ///< control period [ns]
    std::uint32_t wake_every_periods{40};       ///< control periods a wake-up [-]
    std::uint32_t periods_per_sample{40};       ///< control periods in one DriveTelemetry [-]
    std::int64_t statistics_ns{1'000'000'000};  ///< between two RealTimeStatistics [ns]
    TimingStatistics::Parameters timing{};
    WaitMode wait{WaitMode::sleep};
    SchedulingPolicy policy{SchedulingPolicy::fifo};
  };

  /// `log` is called with a sentence where the drive goes to FAULT, where its torque begins to ramp to zero,
  /// and where the housekeeping thread stops.
  TelemetryTask(
      const Parameters& parameters, TelemetrySender& sender, SharedState& shared,
      std::function<void(const std::string&)> log = [](const std::string&) {})
      : parameters_{parameters},
        sender_{sender},
        shared_{shared},
        log_{std::move(log)},
        waveform_{parameters.period_ns},
        timing_{parameters.timing},
        report_{shared} {}

  /// The first intervals begin at now_ns [ns]. `rights`: those granted to the control thread.
  void start(std::int64_t now_ns, const RightsReport& rights);
  void poll(std::int64_t now_ns);
  /// Once the control thread has ended: publishes the rest.
  void finish();

  /// Statistics of the run; once the thread has ended.
  [[nodiscard]] const TimingStatistics& timing() const noexcept { return timing_; }

 private:
  void drain_telemetry();
  void record_waveform(const Telemetry<double>& telemetry);
  void publish_waveform();
  void drain_wakes();
  void log_state(const Telemetry<double>& telemetry) const;
  void publish_state(const Telemetry<double>& telemetry, const std::string& reason);
  void publish_timeout(std::int64_t now_ns);
  void publish_statistics();
  void watch_housekeeping();
  [[nodiscard]] RealTimeSample sample() const;

  Parameters parameters_;
  TelemetrySender& sender_;
  SharedState& shared_;
  std::function<void(const std::string&)> log_;
  bool real_time_scheduling_{false};
  bool memory_locked_{false};
  WaveformRecorder waveform_;
  TelemetryInterval<double> interval_{};
  Telemetry<double> newest_{};     // newest record of the drive
  Telemetry<double> published_{};  // record published last as DriveState
  bool any_published_{false};
  std::int64_t next_timeout_ns_{0};  // of the next timeout sample
  TimingStatistics timing_;
  std::int64_t next_statistics_ns_{0};
  CanReport report_;
  ThreadWatch housekeeping_{poll_every_ms};
};

/// Why the drive is in its state, for people. At most 64 characters.
[[nodiscard]] std::string reason_for(const Telemetry<double>& telemetry);

}  // namespace sextant::ecu
