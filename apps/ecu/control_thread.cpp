#include "ecu/control_thread.hpp"

#include <algorithm>

#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

ControlThread::ControlThread(const RealtimeParameters& realtime, std::int32_t period_ns, DriveIo<double>& io,
                             Drive<double>& drive, Crossings& crossings)
    : realtime_{realtime},
      period_ns_{period_ns},
      probe_{realtime.stage_statistics, realtime.gap_limit_ns},
      io_{io, probe_, command_probe_},
      drive_{drive},
      crossings_{crossings},
      commands_{crossings},
      telemetry_{crossings},
      stamped_commands_{commands_, probe_, command_probe_},
      stamped_telemetry_{telemetry_, probe_, crossings.stages},
      task_{{.period_ns = period_ns, .wake_every_periods = realtime.wake_every_periods}, realtime.wait} {}

RightsReport ControlThread::start() {
  worker_.start([this] { run(go_.get_future()); });
  return rights_.get_future().get();
}

void ControlThread::answer(bool may_go) {
  if (answered_) return;
  answered_ = true;
  go_.set_value(may_go);
}

void ControlThread::join() {
  answer(false);
  worker_.join();
}

void ControlThread::run(std::future<bool> may_go) {
  crossings_.control_thread_id.store(gettid(), std::memory_order_release);
  rights_.set_value(set_up_control_thread(realtime_, task_.schedule().parameters().wake_period_ns()));
  const bool goes = may_go.get();
  finished_ns_ = task_.start();
  while (goes && drive_.state() != DriveState::shutdown) wake_up(task_.wait());
  crossings_.stopped.store(true, std::memory_order_release);
}

void ControlThread::wake_up(const WakeSchedule::Wake& wake) noexcept {
  const std::int64_t woken_ns = task_.woken_ns();
  probe_.wake();
  crossings_.beat(woken_ns);
  WakeRecord record = record_of(wake);
  run_periods(wake.deadline_ns);
  crossings_.status.store(telemetry_.last());
  finished_ns_ = now_ns();
  record.body_ns = finished_ns_ - woken_ns;
  record.periods = periods_;
  record.command_to_gate_ns = command_probe_.take();
  probe_.finish(record.body_ns);
  crossings_.wakes.push(record);
}

WakeRecord ControlThread::record_of(const WakeSchedule::Wake& wake) noexcept {
  probe_.see(task_.began_ns() - finished_ns_, GapPlace::between);
  // Work that ended before the deadline owes nothing: only the waiting can have made this wake-up late.
  const bool body_overran = task_.began_ns() > task_.woken_ns() - wake.latency_ns;
  if (!body_overran) probe_.clear_gap();
  probe_.see(task_.longest_gap_ns(), GapPlace::waiting);
  const WakeSchedule::Counters& counters = task_.schedule().counters();
  const WakeRecord record{.deadline_ns = wake.deadline_ns,
                          .latency_ns = wake.latency_ns,
                          .periods_skipped = counters.periods_skipped,
                          .overruns = counters.overruns,
                          .overrun = wake.overrun(),
                          .body_overran = body_overran,
                          .gap = probe_.gap(),
                          .longest_gap_ns = probe_.take_longest_ns()};
  // A gap that has made its miss makes no other: what comes after it is another's work.
  probe_.fade_gap(wake.overrun() ? 0 : wake.latency_ns);
  return record;
}

void ControlThread::run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING {
  for (int n = 0; n < realtime_.wake_every_periods; ++n) {
    run_cycle(deadline_ns + std::int64_t{n} * period_ns_, io_, stamped_commands_, drive_, stamped_telemetry_);
  }
  periods_ += std::uint64_t(realtime_.wake_every_periods);
}

}  // namespace sextant::ecu
