#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"

namespace sextant::ecu {

/// The watchdog: orders the gates off when the control thread has not woken up for too long, and takes the
/// gate-enable line away itself where there is one, so that the gates open while that thread still hangs. It
/// shares nothing with the control thread but two atomics and that line.
class WatchdogThread {
 public:
  /// `open_gates` is called from this thread, every 2 ms while the control thread is late.
  WatchdogThread(
      std::int64_t limit_ns, Crossings& crossings, std::function<void()> open_gates = [] {})
      : limit_ns_{limit_ns}, crossings_{crossings}, open_gates_{std::move(open_gates)} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  static constexpr std::int64_t look_every_ns = 2'000'000;  ///< [ns]
  /// The body of the loop at now_ns.
  void look(std::int64_t now_ns);

 private:
  void run();

  std::int64_t limit_ns_;
  Crossings& crossings_;
  std::function<void()> open_gates_;
  Worker worker_{"sextant-wdog"};
};

}  // namespace sextant::ecu
