#include "ecu/virtual_time/virtual_unit.hpp"

#include <utility>

namespace sextant::ecu {
namespace {

/// The probe of a drive's periods: its recorder and the observer of the run. For virtual time alone: an
/// observer may allocate.
struct VirtualProbe {
  CycleRecorder* cycles;
  const std::function<void(const Telemetry<double>&)>& observer;
  const Telemetry<double>& newest;  // pushed last

  void begins(std::int64_t t_ns) const noexcept {
    if (cycles != nullptr) cycles->begins(t_ns);
  }
  void has_read(const Measurement<double>& measurement) const noexcept {
    if (cycles != nullptr) cycles->has_read(measurement);
  }
  void has_request(const DriveRequest<double>& request) const noexcept {
    if (cycles != nullptr) cycles->has_request(request);
  }
  void has_stepped(const DriveOutput<double>& output) const noexcept {
    if (cycles != nullptr) cycles->has_stepped(output);
  }
  void has_written() const noexcept {
    if (cycles != nullptr) cycles->has_written();
  }
  void has_pushed() const noexcept {
    if (observer) observer(newest);
  }
};

}  // namespace

VirtualUnit::VirtualUnit(Parts parts, const VirtualClock& clock)
    : clock_{clock},
      unit_{parts.unit},
      recorder_{parts.recorder},
      late_wakes_{std::move(parts.late_wakes)},
      observer_{std::move(parts.observer)},
      schedule_{unit_.control().wakes()},
      report_{unit_.shared()},
      next_watchdog_ns_{clock.now_ns()},
      next_transmit_ns_{clock.now_ns()} {
  schedule_.start(clock.now_ns());
  report_.start(clock.now_ns());
  unit_.transmit().start(clock.now_ns());
}

void VirtualUnit::join(VirtualTimeline& timeline) {
  timeline.add({.next_due_ns = [this] { return is_running() ? next_wake_ns() : never_ns; },
                .act = [this] { wake_up(); }});
  timeline.add({.next_due_ns = [this] { return is_running() ? next_watchdog_ns_ : never_ns; },
                .act = [this] { poll_watchdog(); }});
  timeline.add({.next_due_ns = [this] { return sent_last_ ? never_ns : next_transmit_ns_; },
                .act = [this] { transmit(); }});
}

void VirtualUnit::wake_up() {
  const std::int64_t now = clock_.now_ns();
  late_wakes_.woken(schedule_.next_deadline_ns());
  const WakeSchedule::Wake wake = schedule_.wake(now);
  VirtualProbe probe{unit_.recorder(), observer_, unit_.control().last()};
  unit_.control().wake_up(now, wake.deadline_ns, schedule_.counters().overruns_in_a_row, unit_.io(), probe);
  Telemetry<double> telemetry;
  while (unit_.shared().telemetry.pop(telemetry)) recorder_.add(telemetry);
  report_.add({.deadline_ns = wake.deadline_ns,
               .latency_ns = wake.latency_ns,
               .periods_missed = schedule_.counters().periods_missed});
  if (!unit_.control().has_shut_down()) return;
  unit_.shared().stopped.store(true, std::memory_order_release);
  next_transmit_ns_ = now;
}

void VirtualUnit::poll_watchdog() {
  unit_.watchdog().poll(clock_.now_ns());
  next_watchdog_ns_ += WatchdogTask::poll_every_ns;
}

void VirtualUnit::transmit() {
  is_transmitting_ = true;
  if (is_running()) {
    next_transmit_ns_ = unit_.transmit().poll(clock_.now_ns());
  } else {
    unit_.transmit().send_last(clock_.now_ns());
    sent_last_ = true;
  }
  is_transmitting_ = false;
}

}  // namespace sextant::ecu
