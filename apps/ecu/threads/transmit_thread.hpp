#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/transmit_task.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

/// The transmit thread: polls its task when a frame is due, and warns once of a problem of the whole bus.
class TransmitThread {
 public:
  /// offset: of the drive's identifiers. `warn` is called from this thread with a sentence for people.
  TransmitThread(
      CanBus& bus, SharedState& shared, IdentifierOffset offset = {},
      std::function<void(const std::string& sentence)> warn = [](const std::string&) {})
      : bus_{bus}, shared_{shared}, warn_{std::move(warn)}, task_{bus, shared, offset} {}

  /// The age of the last status frame counts from this call, also where the thread never runs.
  void start() {
    task_.start(now_ns());
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

  /// For after the join.
  [[nodiscard]] const TransmitTask& task() const noexcept { return task_; }

 private:
  void run() {
    while (!shared_.stopped.load(std::memory_order_acquire)) {
      const std::int64_t until_ns = task_.poll(now_ns());
      warn_of_trouble(now_ns());
      std::this_thread::sleep_for(std::chrono::nanoseconds{until_ns - now_ns()});
    }
    task_.send_last(now_ns());
  }

  void warn_of_trouble(std::int64_t now_ns) {
    if (warned_ || now_ns < next_check_ns_) return;
    next_check_ns_ = now_ns + ns_per_s;
    const std::string trouble = bus_.trouble();
    warned_ = !trouble.empty();
    if (warned_) warn_(trouble);
  }

  CanBus& bus_;
  SharedState& shared_;
  std::function<void(const std::string& sentence)> warn_;
  TransmitTask task_;
  std::int64_t next_check_ns_{0};
  bool warned_{false};
  NamedThread thread_{"sextant-can-tx"};
};

}  // namespace sextant::ecu
