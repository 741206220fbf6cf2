#pragma once

#include <cstdint>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"

namespace sextant::ecu {

/// The watchdog: orders the gates off when the control thread has not woken up for too long. It shares
/// nothing with the control thread but two atomics.
class WatchdogThread {
 public:
  WatchdogThread(std::int64_t limit_ns, Crossings& crossings) : limit_ns_{limit_ns}, crossings_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }

 private:
  void run();

  std::int64_t limit_ns_;
  Crossings& crossings_;
  Worker worker_{"sextant-wdog"};
};

}  // namespace sextant::ecu
