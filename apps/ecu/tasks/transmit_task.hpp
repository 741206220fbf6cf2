#pragma once

#include <cstdint>

#include "ecu/shared_state.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/status_encoder.hpp"

namespace sextant::ecu {

/// What the transmit thread does, apart from the thread: the status frames by their cycle times, faults when
/// they change, and at the end the state in which the drive was left. While the control thread has timed out
/// the frames carry `status_of_timed_out_drive`. Reads no clock.
class TransmitTask {
 public:
  TransmitTask(CanBus& bus, SharedState& shared) noexcept : bus_{bus}, shared_{shared} {}

  /// Sends what is due at now_ns; returns when to poll again. [ns]
  std::int64_t poll(std::int64_t now_ns);
  /// Sends what is due, and MCU_TorqueStatus with the state in which the drive was left, due or not.
  void send_last(std::int64_t now_ns);
  /// Values that did not fit into their signals; once the thread has ended. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return encoder_.clamped(); }

 private:
  void send_due(std::int64_t now_ns);

  CanBus& bus_;
  SharedState& shared_;
  StatusEncoder encoder_{};
};

}  // namespace sextant::ecu
