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
#include "ecu/threads/thread_watch.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The housekeeping thread: ten times a second it reads the kernel's scheduling statistics of the control
/// thread (time without a processor, switches, page faults, stolen time). They distinguish a gap in that
/// thread's execution from a long execution, without a system call on it. By ThreadWatch it also warns when
/// the telemetry thread stops, and when the watchdog thread does, which it makes a fault.
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
    constexpr int polls_per_sample = 10;
    const SchedulerSampler sampler{shared_.control_thread_id.load(std::memory_order_acquire)};
    const SchedulerSample begin = sampler.sample();
    for (int poll = 1; !shared_.stopped.load(std::memory_order_acquire); ++poll) {
      std::this_thread::sleep_for(std::chrono::milliseconds{poll_every_ms});
      watch_telemetry();
      watch_watchdog();
      shared_.housekeeping_polls.fetch_add(1, std::memory_order_relaxed);
      if (poll % polls_per_sample != 0) continue;
      const SchedulerSample sample = sampler.sample().since(begin);
      // Not valid once the control thread has ended: the sample before it stays.
      if (sample.valid) shared_.scheduler.store(sample);
    }
  }

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

  static constexpr int poll_every_ms = 10;  ///< [ms]

  SharedState& shared_;
  std::function<void(const std::string& sentence)> warn_;
  ThreadWatch telemetry_{poll_every_ms};
  ThreadWatch watchdog_{poll_every_ms};
  NamedThread thread_{"sextant-house"};
};

}  // namespace sextant::ecu
