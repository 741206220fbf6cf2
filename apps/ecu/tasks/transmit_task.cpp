#include "ecu/tasks/transmit_task.hpp"

#include <algorithm>

#include "ecu/tasks/timed_out_drive.hpp"

namespace sextant::ecu {

std::int64_t TransmitTask::poll(std::int64_t now_ns) {
  // Faults go out on change, so the status is polled more often than the shortest cycle time.
  constexpr std::int64_t poll_every_ns = 5'000'000;
  send_due(now_ns);
  return std::clamp(encoder_.next_due_ns(), now_ns, now_ns + poll_every_ns);
}

void TransmitTask::send_last(std::int64_t now_ns) {
  send_due(now_ns);
  const StatusExtras extras{.real_time = shared_.real_time.latest()};
  (void)bus_.send(encoder_.frame(StatusMessage::torque_status, shared_.status.latest(), extras));
}

void TransmitTask::send_due(std::int64_t now_ns) {
  const bool timed_out = shared_.control_timed_out(now_ns);
  const Telemetry<double>& last = shared_.status.latest();
  const StatusExtras extras{.real_time = shared_.real_time.latest(), .measured = !timed_out};
  const Telemetry<double> status = timed_out ? status_of_timed_out_drive(last) : last;
  for (const CanFrame& frame : encoder_.due(now_ns, status, extras)) (void)bus_.send(frame);
}

}  // namespace sextant::ecu
