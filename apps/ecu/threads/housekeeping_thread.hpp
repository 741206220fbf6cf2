#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "ecu/shared_state.hpp"
#include "ecu/threads/named_thread.hpp"
#include "ecu/threads/telemetry_watch.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The housekeeping thread: ten times a second it reads the kernel's scheduling statistics of the control
/// thread (time without a processor, switches, page faults, stolen time). They distinguish a gap in that
/// thread's execution from a long execution, without a system call on it. It also warns when the telemetry
/// thread stops, by telemetry_watch.hpp.
class HousekeepingThread {
 public:
  /// `warn` is called from this thread with a sentence for people.
  explicit HousekeepingThread(
      SharedState& shared, std::function<void(const std::string& sentence)> warn = [](const std::string&) {})
      : shared_{shared}, warn_{std::move(warn)} {}

  /// To be called when the control thread has been set up; the statistics count from here.
  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

 private:
  void run() {
    using namespace std::chrono_literals;
    constexpr int polls_per_sample = 10;
    const SchedulerSampler sampler{shared_.control_thread_id.load(std::memory_order_acquire)};
    const SchedulerSample begin = sampler.sample();
    for (int poll = 1; !shared_.stopped.load(std::memory_order_acquire); ++poll) {
      std::this_thread::sleep_for(10ms);
      watch_telemetry();
      if (poll % polls_per_sample != 0) continue;
      const SchedulerSample sample = sampler.sample().since(begin);
      // Not valid once the control thread has ended: the sample before it stays.
      if (sample.valid) shared_.scheduler.store(sample);
    }
  }

  void watch_telemetry() {
    const std::uint64_t polls = shared_.telemetry_polls.load(std::memory_order_relaxed);
    switch (telemetry_.step(polls)) {
      case TelemetryWatch::Change::none:
        return;
      case TelemetryWatch::Change::stopped:
        shared_.telemetry_stalls.fetch_add(1, std::memory_order_relaxed);
        return warn_("the telemetry thread has stopped: nothing is published, the drive goes on");
      case TelemetryWatch::Change::resumed:
        return warn_("the telemetry thread runs again");
    }
  }

  SharedState& shared_;
  std::function<void(const std::string& sentence)> warn_;
  TelemetryWatch telemetry_{};
  NamedThread thread_{"sextant-house"};
};

}  // namespace sextant::ecu
