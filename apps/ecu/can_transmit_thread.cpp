#include "ecu/can_transmit_thread.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

#include "ecu/silent_drive.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

void CanTransmitThread::run() {
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    const std::int64_t until_ns = look(now_ns());
    warn_of_trouble(now_ns());
    std::this_thread::sleep_for(std::chrono::nanoseconds{until_ns - now_ns()});
  }
  look_last(now_ns());
}

std::int64_t CanTransmitThread::look(std::int64_t now_ns) {
  // Faults go out on change, so the status is looked at more often than the shortest cycle time.
  constexpr std::int64_t look_every_ns = 5'000'000;
  send_due(now_ns);
  return std::clamp(encoder_.next_due_ns(), now_ns, now_ns + look_every_ns);
}

void CanTransmitThread::warn_of_trouble(std::int64_t now_ns) {
  if (warned_ || now_ns < next_check_ns_) return;
  next_check_ns_ = now_ns + ns_per_s;
  const std::string trouble = bus_.trouble();
  warned_ = !trouble.empty();
  if (warned_) warn_(trouble);
}

void CanTransmitThread::look_last(std::int64_t now_ns) {
  send_due(now_ns);
  (void)bus_.send(encoder_.frame(StatusMessage::torque_status, crossings_.status.latest(), extras()));
}

StatusExtras CanTransmitThread::extras() {
  const StatisticsReport& statistics = crossings_.statistics.latest();
  StatusExtras extras;
  extras.real_time = {statistics.periods_skipped, double(statistics.worst_body_ns) * 1e-9,
                      double(statistics.worst_latency_ns) * 1e-9, statistics.telemetry_dropped};
  return extras;
}

void CanTransmitThread::send_due(std::int64_t now_ns) {
  const bool silent = crossings_.control_silent(now_ns);
  const Telemetry<double>& last = crossings_.status.latest();
  StatusExtras more = extras();
  more.measured = !silent;
  const Telemetry<double> status = silent ? status_of_silent_drive(last) : last;
  for (const CanFrame& frame : encoder_.due(now_ns, status, more)) (void)bus_.send(frame);
}

}  // namespace sextant::ecu
