#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/telemetry_task.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

/// The telemetry thread: polls its task every millisecond.
class TelemetryThread {
 public:
  /// As TelemetryTask; `poll_publisher` and `log` are called from this thread.
  TelemetryThread(
      const TelemetryTask::Parameters& parameters, TelemetrySender& sender, SharedState& shared,
      std::function<void(std::int64_t)> poll_publisher = [](std::int64_t) {},
      std::function<void(const std::string&)> log = [](const std::string&) {})
      : shared_{shared}, task_{parameters, sender, shared, std::move(poll_publisher), std::move(log)} {}

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
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    task_.finish();
  }

  SharedState& shared_;
  TelemetryTask task_;
  NamedThread thread_{"sextant-dds"};
};

}  // namespace sextant::ecu
