#include "ecu/virtual_time/virtual_ecu.hpp"

#include <utility>

namespace sextant::ecu {
namespace {

/// Passes each record to the shared state and to the observer of the run. For virtual time alone: an observer
/// may allocate.
struct ObservedTelemetry {
  SharedTelemetry& shared;
  const std::function<void(const Telemetry<double>&)>& observer;

  void push(const Telemetry<double>& telemetry) noexcept {
    shared.push(telemetry);
    if (observer) observer(telemetry);
  }
};

}  // namespace

VirtualEcu::VirtualEcu(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus,
                       DriveIo<double>& io, Drive<double>& drive, RunRecorder& recorder, LateWakes late_wakes)
    : clock_{clock},
      bus_{bus},
      io_{io},
      recorder_{recorder},
      late_wakes_{std::move(late_wakes)},
      observer_{parameters.observer},
      schedule_{
          {.period_ns = parameters.period_ns, .wake_every_periods = parameters.realtime.wake_every_periods}},
      shared_{parameters.period_ns, parameters.realtime.wake_every_periods, parameters.realtime.watchdog_ns},
      receive_{shared_, parameters.identifier_offset},
      control_{schedule_.parameters(), drive, shared_, parameters.realtime.overrun_limit},
      watchdog_{shared_},
      transmit_{bus, shared_, parameters.identifier_offset},
      report_{shared_},
      next_watchdog_ns_{clock.now_ns()},
      next_transmit_ns_{clock.now_ns()} {
  shared_.cycles = parameters.cycles;
  schedule_.start(clock.now_ns());
  report_.start(clock.now_ns());
  transmit_.start(clock.now_ns());
  bus_.listen([this](const CanFrame& frame) { recorder_.add(frame, clock_.now_ns()); });
}

void VirtualEcu::join(VirtualTimeline& timeline) {
  timeline.add({.next_due_ns = [this] { return is_running() ? bus_.next_arrival_ns() : never_ns; },
                .act = [this] { receive(); }});
  timeline.add({.next_due_ns = [this] { return is_running() ? next_wake_ns() : never_ns; },
                .act = [this] { wake_up(); }});
  timeline.add({.next_due_ns = [this] { return is_running() ? next_watchdog_ns_ : never_ns; },
                .act =
                    [this] {
                      watchdog_.poll(clock_.now_ns());
                      next_watchdog_ns_ += WatchdogTask::poll_every_ns;
                    }});
  timeline.add({.next_due_ns = [this] { return sent_last_ ? never_ns : next_transmit_ns_; },
                .act = [this] { transmit(); }});
}

std::int64_t VirtualEcu::next_wake_ns() const noexcept {
  return late_wakes_.wake_ns(schedule_.next_deadline_ns());
}

void VirtualEcu::receive() {
  CanFrame frame;
  while (bus_.receive(frame, std::chrono::nanoseconds{0}) == CanReceive::got) receive_.on_frame(frame);
}

void VirtualEcu::wake_up() {
  const std::int64_t now = clock_.now_ns();
  late_wakes_.woken(schedule_.next_deadline_ns());
  const WakeSchedule::Wake wake = schedule_.wake(now);
  ObservedTelemetry telemetry{control_.telemetry(), observer_};
  control_.wake_up(now, wake.deadline_ns, schedule_.counters().overruns_in_a_row, io_, control_.commands(),
                   telemetry);
  drain();
  report_.add({.deadline_ns = wake.deadline_ns,
               .latency_ns = wake.latency_ns,
               .periods_missed = schedule_.counters().periods_missed});
  if (!control_.has_shut_down()) return;
  shared_.stopped.store(true, std::memory_order_release);
  next_transmit_ns_ = now;
}

void VirtualEcu::drain() {
  Telemetry<double> telemetry;
  while (shared_.telemetry.pop(telemetry)) recorder_.add(telemetry);
}

void VirtualEcu::transmit() {
  if (is_running()) {
    next_transmit_ns_ = transmit_.poll(clock_.now_ns());
    return;
  }
  transmit_.send_last(clock_.now_ns());
  sent_last_ = true;
}

}  // namespace sextant::ecu
