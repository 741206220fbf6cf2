#include "ecu/watchdog_thread.hpp"

#include <chrono>

#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

void WatchdogThread::start() {
  thread_ = std::thread{[this] { run(); }};
}

void WatchdogThread::join() {
  if (thread_.joinable()) thread_.join();
}

void WatchdogThread::run() {
  (void)name_thread("sextant-watchdog");
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    const std::int64_t beat_ns = crossings_.heartbeat_ns.load(std::memory_order_acquire);
    const bool late = beat_ns != 0 && now_ns() - beat_ns > limit_ns_;
    // The drive latches the fault; the request itself ends when the control thread is back.
    crossings_.gates_disabled.store(late, std::memory_order_release);
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
  }
}

}  // namespace sextant::ecu
