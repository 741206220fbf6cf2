#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/watchdog_task.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The watchdog thread: polls its task every 2 ms. It shares only two atomics and the gate-enable line with
/// the control thread; its count of polls shows the housekeeping thread that it runs. In hard real time it
/// has the highest priority of the process, so that it turns the gates off even while another thread, the
/// control thread included, never yields the processor.
class WatchdogThread {
 public:
  /// `inhibit_gates` is called from this thread, every 2 ms while the control thread has timed out.
  /// `control_priority`: SCHED_FIFO priority of the control thread, 0 for none [-]; with one this thread
  /// requests `watchdog_priority`, and where that is refused the control thread's.
  explicit WatchdogThread(
      SharedState& shared, std::function<void()> inhibit_gates = [] {}, int control_priority = 0)
      : shared_{shared}, control_priority_{control_priority}, task_{shared, std::move(inhibit_gates)} {}

  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

 private:
  void run() {
    request_priority();
    while (!shared_.stopped.load(std::memory_order_acquire)) {
      task_.poll(now_ns());
      shared_.watchdog_polls.fetch_add(1, std::memory_order_relaxed);
      std::this_thread::sleep_for(std::chrono::nanoseconds{WatchdogTask::poll_every_ns});
    }
  }

  void request_priority() const {
    if (control_priority_ == 0 || use_fifo_scheduling(watchdog_priority).granted) return;
    // An rtprio limit may lie between the two. The control thread reports any other refusal: its own request
    // is then refused too.
    (void)use_fifo_scheduling(control_priority_);
  }

  SharedState& shared_;
  int control_priority_;
  WatchdogTask task_;
  NamedThread thread_{"sextant-wdog"};
};

}  // namespace sextant::ecu
