#pragma once

#include <algorithm>
#include <cstdint>

#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/timed_out_drive.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/status_encoder.hpp"

namespace sextant::ecu {

/// The work of the transmit thread, without the thread: sends the status frames by their cycle times, the
/// faults when they change, and at the end the last state of the drive. While the control thread has timed
/// out the frames carry `status_of_timed_out_drive`. Reads no clock.
class TransmitTask {
 public:
  /// offset: of the drive's identifiers.
  TransmitTask(CanBus& bus, SharedState& shared, IdentifierOffset offset = {}) noexcept
      : bus_{bus}, shared_{shared}, encoder_{offset} {}

  /// From now_ns on frames are to be sent: the age of the last one counts from here. [ns]
  void start(std::int64_t now_ns) noexcept { note_sent(now_ns); }

  /// Sends what is due at now_ns; returns when to poll again. [ns]
  std::int64_t poll(std::int64_t now_ns) {
    // Faults are sent on change, so the status is polled more often than the shortest cycle time.
    constexpr std::int64_t poll_every_ns = 5'000'000;
    send_due(now_ns);
    return std::clamp(encoder_.next_due_ns(), now_ns, now_ns + poll_every_ns);
  }

  /// Sends what is due, and MCU_TorqueStatus with the last state of the drive, due or not.
  void send_last(std::int64_t now_ns) {
    send_due(now_ns);
    const StatusExtras extras{.real_time = shared_.real_time.latest()};
    (void)bus_.send(encoder_.frame(StatusMessage::torque_status, shared_.status.latest(), extras));
  }

  /// Values beyond the range of their signals; once the thread has ended. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return encoder_.clamped(); }

 private:
  void send_due(std::int64_t now_ns) {
    const bool timed_out = shared_.control_timed_out(now_ns);
    const Telemetry<double>& last = shared_.status.latest();
    const StatusExtras extras{.real_time = shared_.real_time.latest(), .measured = !timed_out};
    const Telemetry<double> status = timed_out ? status_of_timed_out_drive(last) : last;
    for (const CanFrame& frame : encoder_.due(now_ns, status, extras)) {
      if (bus_.send(frame) == CanSend::ok) note_sent(now_ns);
    }
  }

  void note_sent(std::int64_t now_ns) noexcept {
    shared_.status_sent_ns.store(now_ns, std::memory_order_relaxed);
  }

  CanBus& bus_;
  SharedState& shared_;
  StatusEncoder encoder_;
};

}  // namespace sextant::ecu
