#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/telemetry_task.hpp"
#include "ecu/threads/named_thread.hpp"
#include "ecu/threads/thread_watch.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

/// The telemetry thread: polls its task every millisecond, and logs when the housekeeping thread stops.
class TelemetryThread {
 public:
  /// As TelemetryTask; `poll_publisher` and `log` are called from this thread.
  TelemetryThread(
      const TelemetryTask::Parameters& parameters, TelemetrySender& sender, SharedState& shared,
      std::function<void(std::int64_t)> poll_publisher = [](std::int64_t) {},
      std::function<void(const std::string&)> log = [](const std::string&) {})
      : shared_{shared},
        log_{std::move(log)},
        task_{parameters, sender, shared, std::move(poll_publisher), log_} {}

  /// `rights`: those granted to the control thread.
  void start(const RightsReport& rights = {}) {
    thread_.start([this, rights] { run(rights); });
  }
  void join() { thread_.join(); }

  /// For after the join.
  [[nodiscard]] const TelemetryTask& task() const noexcept { return task_; }

 private:
  void run(const RightsReport& rights) {
    task_.start(now_ns(), rights);
    while (!shared_.stopped.load(std::memory_order_acquire)) {
      task_.poll(now_ns());
      shared_.telemetry_polls.fetch_add(1, std::memory_order_relaxed);
      watch_housekeeping();
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    task_.finish();
  }

  void watch_housekeeping() {
    switch (housekeeping_.step(shared_.housekeeping_polls.load(std::memory_order_relaxed))) {
      case ThreadWatch::Change::none:
        return;
      case ThreadWatch::Change::stopped:
        return log_("the housekeeping thread has stopped: nothing watches the watchdog, the drive goes on");
      case ThreadWatch::Change::resumed:
        return log_("the housekeeping thread runs again");
    }
  }

  SharedState& shared_;
  std::function<void(const std::string&)> log_;
  TelemetryTask task_;
  ThreadWatch housekeeping_{1};
  NamedThread thread_{"sextant-dds"};
};

}  // namespace sextant::ecu
