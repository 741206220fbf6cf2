#pragma once

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/command_receiver.hpp"

namespace sextant::ecu {

/// The receive thread: sees every frame, checks identity and end-to-end protection, and hands the newest
/// command to the control thread.
class CanReceiveThread {
 public:
  CanReceiveThread(CanBus& bus, Crossings& crossings) : bus_{bus}, crossings_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// What became of the frames; for after the join.
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return receiver_; }

 private:
  void run();

  CanBus& bus_;
  Crossings& crossings_;
  CommandReceiver receiver_{};
  Worker worker_{"sextant-can-rx"};
};

}  // namespace sextant::ecu
