#pragma once

#include <cstdint>
#include <thread>

#include "ecu/crossings.hpp"

namespace sextant::ecu {

/// The watchdog: disables the gates when the control thread has not woken up for too long. It shares nothing
/// with the control thread but two atomics.
class WatchdogThread {
 public:
  WatchdogThread(std::int64_t limit_ns, Crossings& crossings) : limit_ns_{limit_ns}, crossings_{crossings} {}

  void start();
  void join();

 private:
  void run();

  std::int64_t limit_ns_;
  Crossings& crossings_;
  std::thread thread_{};
};

}  // namespace sextant::ecu
