#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "ecu/tasks/receive_task.hpp"
#include "ecu/threads/flood_limit.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The receive thread: waits for frames and passes each to the tasks of the drives.
class ReceiveThread {
 public:
  /// Nothing is owned; all must outlive this object. is_over: ends the thread. fifo_priority: SCHED_FIFO
  /// priority of the thread where it is granted; 0 for none [-].
  ReceiveThread(CanBus& bus, std::vector<ReceiveTask*> tasks, const std::atomic<bool>& is_over,
                int fifo_priority = 0)
      : bus_{bus}, tasks_{std::move(tasks)}, is_over_{is_over}, fifo_priority_{fifo_priority} {}

  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

  /// From the arrival of an accepted command to its hand-over to the control thread; for after the join.
  [[nodiscard]] const LatencyHistogram& hand_over() const noexcept { return hand_over_; }

 private:
  void run() {
    using namespace std::chrono_literals;
    // The control thread reports a refusal: its own request is then refused too.
    if (fifo_priority_ > 0) (void)use_fifo_scheduling(fifo_priority_);
    CanFrame frame;
    FloodLimit flood;
    while (!is_over_.load(std::memory_order_acquire)) {
      const std::int64_t called_ns = now_ns();
      const CanReceive result = bus_.receive(frame, 20ms);
      // `receive` returns these without waiting; the pause bounds the processor time.
      if (result == CanReceive::down || result == CanReceive::error) std::this_thread::sleep_for(5ms);
      if (result != CanReceive::got) continue;
      for (ReceiveTask* task : tasks_) {
        if (task->on_frame(frame)) hand_over_.record(now_ns() - frame.received_ns);
      }
      if (flood.must_pause(called_ns, frame.received_ns)) {
        std::this_thread::sleep_for(std::chrono::nanoseconds{FloodLimit::pause_ns});
      }
    }
  }

  CanBus& bus_;
  std::vector<ReceiveTask*> tasks_;
  const std::atomic<bool>& is_over_;
  int fifo_priority_;
  LatencyHistogram hand_over_{};
  NamedThread thread_{"sextant-can-rx"};
};

}  // namespace sextant::ecu
