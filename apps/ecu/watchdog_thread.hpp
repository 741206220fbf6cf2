#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"

namespace sextant::ecu {

/// The watchdog: orders the gates off when the control thread has not woken up for too long, and takes the
/// gate-enable line away itself where there is one, so that the gates open while that thread still hangs. It
/// shares nothing with the control thread but two atomics and that line. In hard real time it stands above
/// every other thread of the process: what keeps a processor busy for ever, the control thread among them,
/// does not keep the gates closed.
class WatchdogThread {
 public:
  /// `open_gates` is called from this thread, every 2 ms while the control thread is late.
  /// `control_priority`: SCHED_FIFO priority of the control thread, 0 for none [-]; with one this thread asks
  /// for `watchdog_priority`, and where that is refused for the control thread's.
  explicit WatchdogThread(
      Crossings& crossings, std::function<void()> open_gates = [] {}, int control_priority = 0)
      : crossings_{crossings}, open_gates_{std::move(open_gates)}, control_priority_{control_priority} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  static constexpr std::int64_t look_every_ns = 2'000'000;  ///< [ns]
  /// The body of the loop at now_ns.
  void look(std::int64_t now_ns);

 private:
  void run();
  void ask_for_priority() const;

  Crossings& crossings_;
  std::function<void()> open_gates_;
  int control_priority_;
  Worker worker_{"sextant-wdog"};
};

}  // namespace sextant::ecu
