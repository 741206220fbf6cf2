#pragma once

#include <cstdint>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/status_encoder.hpp"

namespace sextant::ecu {

/// The transmit thread: sends the status frames by their cycle times, faults when they change, and at the end
/// the state in which the drive was left.
class CanTransmitThread {
 public:
  CanTransmitThread(CanBus& bus, Crossings& crossings) : bus_{bus}, crossings_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// The body of the loop at now_ns: sends what is due and returns when to look again. [ns]
  std::int64_t look(std::int64_t now_ns);
  /// The end: what is due, and the state in which the drive was left, whatever its cycle says.
  void look_last(std::int64_t now_ns);
  /// Values that did not fit into their signals; for after the join. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return encoder_.clamped(); }

 private:
  void run();
  void send_due(std::int64_t now_ns);
  [[nodiscard]] StatusExtras extras();

  CanBus& bus_;
  Crossings& crossings_;
  StatusEncoder encoder_{};
  Worker worker_{"sextant-can-tx"};
};

}  // namespace sextant::ecu
