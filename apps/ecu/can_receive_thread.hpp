#pragma once

#include <cstdint>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/command_receiver.hpp"
#include "sextant/realtime/latency_histogram.hpp"

namespace sextant::ecu {

/// The receive thread: sees every frame, checks identity and end-to-end protection, and hands the newest
/// command to the control thread.
class CanReceiveThread {
 public:
  /// fifo_priority: SCHED_FIFO priority of the thread where it is granted; 0 for none [-].
  CanReceiveThread(CanBus& bus, Crossings& crossings, int fifo_priority = 0)
      : bus_{bus}, crossings_{crossings}, fifo_priority_{fifo_priority} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// The body of the loop: what becomes of one frame. True for an accepted command. Reads no clock.
  bool take(const CanFrame& frame);
  /// From the arrival of an accepted command to its hand-over to the control thread; for after the join.
  [[nodiscard]] const LatencyHistogram& hand_over() const noexcept { return hand_over_; }
  /// What became of the frames; for after the join.
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return receiver_; }

 private:
  void run();

  CanBus& bus_;
  Crossings& crossings_;
  int fifo_priority_;
  CommandReceiver receiver_{};
  LatencyHistogram hand_over_{};
  Worker worker_{"sextant-can-rx"};
};

}  // namespace sextant::ecu
