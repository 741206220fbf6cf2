#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/thread_watch.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The work of the housekeeping thread for a drive, without the thread: at every tenth poll it reads the
/// kernel's scheduling statistics of the control thread (time without a processor, switches, page faults,
/// stolen time). They distinguish a gap in that thread's execution from a long execution, without a system
/// call on it. By ThreadWatch it also warns when the telemetry thread stops, and when the watchdog thread
/// does, which it makes a fault.
class HousekeepingTask {
 public:
  static constexpr int poll_every_ms = 10;  ///< [ms]

  /// `warn` is called with a sentence for people.
  explicit HousekeepingTask(
      SharedState& shared, std::function<void(const std::string& sentence)> warn = [](const std::string&) {})
      : shared_{shared}, warn_{std::move(warn)} {}

  /// To be called when the control thread has been set up; the statistics count from here.
  void start() {
    begin_ = sampler_.emplace(shared_.control_thread_id.load(std::memory_order_acquire)).sample();
  }

  void poll() {
    watch_telemetry();
    watch_watchdog();
    const std::uint64_t polls = shared_.housekeeping_polls.fetch_add(1, std::memory_order_relaxed) + 1;
    if (!sampler_ || polls % polls_per_sample != 0) return;
    const SchedulerSample sample = sampler_->sample().since(begin_);
    // Not valid once the control thread has ended: the sample before it stays.
    if (sample.valid) shared_.scheduler.store(sample);
  }

 private:
  static constexpr std::uint64_t polls_per_sample = 10;  // [-]

  void watch_telemetry() {
    switch (telemetry_.step(shared_.telemetry_polls.load(std::memory_order_relaxed))) {
      case ThreadWatch::Change::none:
        return;
      case ThreadWatch::Change::stopped:
        shared_.telemetry_stalls.fetch_add(1, std::memory_order_relaxed);
        return warn_("the telemetry thread has stopped: nothing is published, the drive goes on");
      case ThreadWatch::Change::resumed:
        return warn_("the telemetry thread runs again");
    }
  }

  void watch_watchdog() {
    switch (watchdog_.step(shared_.watchdog_polls.load(std::memory_order_relaxed))) {
      case ThreadWatch::Change::none:
        return;
      case ThreadWatch::Change::stopped:
        shared_.watchdog_stopped.store(true, std::memory_order_relaxed);
        return warn_("the watchdog thread has stopped: gates off, FAULT by WATCHDOG until it runs again");
      case ThreadWatch::Change::resumed:
        shared_.watchdog_stopped.store(false, std::memory_order_relaxed);
        return warn_("the watchdog thread runs again");
    }
  }

  SharedState& shared_;
  std::function<void(const std::string& sentence)> warn_;
  std::optional<SchedulerSampler> sampler_{};  // since the start
  SchedulerSample begin_{};
  ThreadWatch telemetry_{poll_every_ms};
  ThreadWatch watchdog_{poll_every_ms};
};

}  // namespace sextant::ecu
