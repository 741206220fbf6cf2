#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "ecu/shared_state.hpp"
#include "ecu/tasks/receive_task.hpp"
#include "ecu/threads/flood_limit.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The receive thread: waits for frames and passes each to its task.
class ReceiveThread {
 public:
  /// offset: of the drive's identifiers. fifo_priority: SCHED_FIFO priority of the thread where it is
  /// granted; 0 for none [-].
  ReceiveThread(CanBus& bus, SharedState& shared, IdentifierOffset offset = {}, int fifo_priority = 0)
      : bus_{bus}, shared_{shared}, fifo_priority_{fifo_priority}, task_{shared, offset} {}

  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

  /// For frames before the start.
  [[nodiscard]] ReceiveTask& task() noexcept { return task_; }
  /// For after the join.
  [[nodiscard]] const ReceiveTask& task() const noexcept { return task_; }
  /// From the arrival of an accepted command to its hand-over to the control thread; for after the join.
  [[nodiscard]] const LatencyHistogram& hand_over() const noexcept { return hand_over_; }

 private:
  void run() {
    using namespace std::chrono_literals;
    // The control thread reports a refusal: its own request is then refused too.
    if (fifo_priority_ > 0) (void)use_fifo_scheduling(fifo_priority_);
    CanFrame frame;
    FloodLimit flood;
    while (!shared_.stopped.load(std::memory_order_acquire)) {
      const std::int64_t called_ns = now_ns();
      const CanReceive result = bus_.receive(frame, 20ms);
      // `receive` returns these without waiting; the pause bounds the processor time.
      if (result == CanReceive::down || result == CanReceive::error) std::this_thread::sleep_for(5ms);
      if (result != CanReceive::got) continue;
      if (task_.on_frame(frame)) hand_over_.record(now_ns() - frame.received_ns);
      if (flood.must_pause(called_ns, frame.received_ns)) {
        std::this_thread::sleep_for(std::chrono::nanoseconds{FloodLimit::pause_ns});
      }
    }
  }

  CanBus& bus_;
  SharedState& shared_;
  int fifo_priority_;
  ReceiveTask task_;
  LatencyHistogram hand_over_{};
  NamedThread thread_{"sextant-can-rx"};
};

}  // namespace sextant::ecu
