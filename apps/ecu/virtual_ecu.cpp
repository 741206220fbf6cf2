#include "ecu/virtual_ecu.hpp"

#include <utility>

namespace sextant::ecu {

VirtualEcu::VirtualEcu(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus,
                       DriveIo<double>& io, Drive<double>& drive, RunRecorder& recorder, LateWakes late_wakes)
    : parameters_{parameters},
      clock_{clock},
      bus_{bus},
      io_{io},
      drive_{drive},
      recorder_{recorder},
      late_wakes_{std::move(late_wakes)},
      crossings_{parameters.period_ns, parameters.realtime.wake_every_periods,
                 parameters.realtime.watchdog_ns},
      receive_{bus, crossings_},
      transmit_{bus, crossings_},
      watchdog_{crossings_},
      commands_{crossings_},
      telemetry_{crossings_},
      schedule_{
          {.period_ns = parameters.period_ns, .wake_every_periods = parameters.realtime.wake_every_periods}},
      report_{crossings_},
      next_look_ns_{clock.now_ns()},
      next_transmit_ns_{clock.now_ns()} {
  schedule_.start(clock.now_ns());
  report_.start(clock.now_ns());
  bus_.listen([this](const CanFrame& frame) { recorder_.add(frame, clock_.now_ns()); });
}

void VirtualEcu::join(VirtualTimeline& timeline) {
  timeline.add({.next_due_ns = [this] { return is_running() ? bus_.next_arrival_ns() : never_ns; },
                .act = [this] { receive(); }});
  timeline.add({.next_due_ns = [this] { return is_running() ? next_wake_ns() : never_ns; },
                .act = [this] { wake_up(); }});
  timeline.add({.next_due_ns = [this] { return is_running() ? next_look_ns_ : never_ns; },
                .act =
                    [this] {
                      watchdog_.look(clock_.now_ns());
                      next_look_ns_ += WatchdogThread::look_every_ns;
                    }});
  timeline.add({.next_due_ns = [this] { return said_last_ ? never_ns : next_transmit_ns_; },
                .act = [this] { transmit(); }});
}

std::int64_t VirtualEcu::next_wake_ns() const noexcept {
  return late_wakes_.wake_ns(schedule_.next_deadline_ns());
}

void VirtualEcu::receive() {
  CanFrame frame;
  while (bus_.receive(frame, std::chrono::nanoseconds{0}) == CanReceive::got) receive_.take(frame);
}

void VirtualEcu::wake_up() {
  const std::int64_t now = clock_.now_ns();
  late_wakes_.woken(schedule_.next_deadline_ns());
  const WakeSchedule::Wake wake = schedule_.wake(now);
  crossings_.beat(now);
  run_periods(wake.deadline_ns);
  crossings_.status.store(telemetry_.last());
  drain();
  report_.add({.deadline_ns = wake.deadline_ns,
               .latency_ns = wake.latency_ns,
               .periods_skipped = schedule_.counters().periods_skipped});
  if (drive_.state() != DriveState::shutdown) return;
  crossings_.stopped.store(true, std::memory_order_release);
  next_transmit_ns_ = now;
}

void VirtualEcu::run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING {
  for (int n = 0; n < parameters_.realtime.wake_every_periods; ++n) {
    run_cycle(deadline_ns + std::int64_t{n} * parameters_.period_ns, io_, commands_, drive_, telemetry_);
  }
}

void VirtualEcu::drain() {
  Telemetry<double> telemetry;
  while (crossings_.telemetry.pop(telemetry)) recorder_.add(telemetry);
}

void VirtualEcu::transmit() {
  if (is_running()) {
    next_transmit_ns_ = transmit_.look(clock_.now_ns());
    return;
  }
  transmit_.look_last(clock_.now_ns());
  said_last_ = true;
}

}  // namespace sextant::ecu
