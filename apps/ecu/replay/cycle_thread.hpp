#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "ecu/replay/cycle_log.hpp"
#include "ecu/threads/named_thread.hpp"

namespace sextant::ecu {

/// The thread that writes the recorded control periods, every 20 ms. Without real-time rights: it waits for
/// the disk.
class CycleThread {
 public:
  /// warn: is told a failure in one sentence.
  CycleThread(CycleLog& log, std::function<void(const std::string&)> warn)
      : log_{log}, warn_{std::move(warn)} {}

  void start() {
    thread_.start([this] { run(); });
  }
  /// After the control thread has ended; the log can then be closed.
  void join() {
    stopped_.store(true, std::memory_order_release);
    thread_.join();
  }

 private:
  void run() {
    while (!stopped_.load(std::memory_order_acquire)) {
      log_.poll();
      if (!log_.failure().empty()) {
        warn_(log_.failure());
        return;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
  }

  CycleLog& log_;
  std::function<void(const std::string&)> warn_;
  std::atomic<bool> stopped_{false};
  NamedThread thread_{"sextant-cycles"};
};

}  // namespace sextant::ecu
