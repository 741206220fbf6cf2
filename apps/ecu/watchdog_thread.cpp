#include "ecu/watchdog_thread.hpp"

#include <chrono>
#include <thread>

#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

void WatchdogThread::ask_for_priority() const {
  if (control_priority_ == 0 || use_fifo_scheduling(watchdog_priority).granted) return;
  // An rtprio limit may end between the two. What else is refused is the control thread's as well, which
  // reports it.
  (void)use_fifo_scheduling(control_priority_);
}

void WatchdogThread::run() {
  ask_for_priority();
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    look(now_ns());
    std::this_thread::sleep_for(std::chrono::nanoseconds{look_every_ns});
  }
}

void WatchdogThread::look(std::int64_t now_ns) {
  // The order is never withdrawn here: the control thread takes it once it is back, and the drive latches the
  // fault.
  if (crossings_.control_silent(now_ns)) open_gates_();
}

}  // namespace sextant::ecu
