#include "ecu/control_thread.hpp"

#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

ControlThread::ControlThread(const RealtimeParameters& realtime, std::int32_t period_ns, DriveIo<double>& io,
                             Drive<double>& drive, Crossings& crossings)
    : realtime_{realtime},
      period_ns_{period_ns},
      io_{io},
      drive_{drive},
      crossings_{crossings},
      commands_{crossings},
      telemetry_{crossings},
      task_{{.period_ns = period_ns, .wake_every_periods = realtime.wake_every_periods}} {}

RightsReport ControlThread::start() {
  std::promise<RightsReport> rights;
  std::future<RightsReport> answer = rights.get_future();
  worker_.start([this, &rights] { run(rights); });
  return answer.get();
}

void ControlThread::run(std::promise<RightsReport>& rights) {
  rights.set_value(set_up_control_thread(realtime_));
  task_.start();
  while (drive_.state() != DriveState::shutdown) {
    const WakeSchedule::Wake wake = task_.wait();
    wake_up(wake, now_ns());
  }
  crossings_.stopped.store(true, std::memory_order_release);
}

void ControlThread::wake_up(const WakeSchedule::Wake& wake, std::int64_t woken_ns) noexcept {
  const std::int64_t before_ns = crossings_.heartbeat_ns.exchange(woken_ns, std::memory_order_acq_rel);
  // Where everything stood still, the watchdog has seen nothing.
  if (before_ns != 0 && woken_ns - before_ns > realtime_.watchdog_ns) {
    crossings_.gates_disabled.store(true, std::memory_order_release);
  }
  run_periods(wake.deadline_ns);
  crossings_.status.store(telemetry_.last());
  const WakeSchedule::Counters& counters = task_.schedule().counters();
  crossings_.wakes.push({wake.deadline_ns, wake.latency_ns, now_ns() - woken_ns, periods_,
                         counters.periods_skipped, counters.overruns});
}

void ControlThread::run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING {
  for (int n = 0; n < realtime_.wake_every_periods; ++n) {
    run_cycle(deadline_ns + std::int64_t{n} * period_ns_, io_, commands_, drive_, telemetry_);
  }
  periods_ += std::uint64_t(realtime_.wake_every_periods);
}

}  // namespace sextant::ecu
