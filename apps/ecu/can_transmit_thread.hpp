#pragma once

#include <thread>

#include "ecu/crossings.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/status_encoder.hpp"

namespace sextant::ecu {

/// The transmit thread: sends the status frames by their cycle times, and faults when they change.
class CanTransmitThread {
 public:
  CanTransmitThread(CanBus& bus, Crossings& crossings) : bus_{bus}, crossings_{crossings} {}

  void start();
  void join();

 private:
  void run();
  void send_due();

  CanBus& bus_;
  Crossings& crossings_;
  StatusEncoder encoder_{};
  std::thread thread_{};
};

}  // namespace sextant::ecu
