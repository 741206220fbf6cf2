#include "ecu/can_transmit_thread.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

void CanTransmitThread::run() {
  // Faults go out on change, so the status is looked at more often than the shortest cycle time.
  constexpr std::int64_t look_every_ns = 5'000'000;
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    send_due();
    const std::int64_t now = now_ns();
    const std::int64_t until = std::clamp(encoder_.next_due_ns(), now, now + look_every_ns);
    std::this_thread::sleep_for(std::chrono::nanoseconds{until - now});
  }
  send_due();
  // Whatever its cycle says: the vehicle is told how the drive was left.
  (void)bus_.send(encoder_.frame(StatusMessage::torque_status, crossings_.status.latest(), extras()));
}

StatusExtras CanTransmitThread::extras() {
  const StatisticsReport& statistics = crossings_.statistics.latest();
  StatusExtras extras;
  extras.real_time = {statistics.periods_skipped, double(statistics.worst_body_ns) * 1e-9,
                      double(statistics.worst_latency_ns) * 1e-9, statistics.telemetry_dropped};
  return extras;
}

void CanTransmitThread::send_due() {
  for (const CanFrame& frame : encoder_.due(now_ns(), crossings_.status.latest(), extras())) {
    (void)bus_.send(frame);
  }
}

}  // namespace sextant::ecu
