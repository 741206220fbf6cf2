#include "ecu/threads/control_thread.hpp"

#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

ControlThread::ControlThread(const RealtimeParameters& realtime, std::int32_t period_ns, DriveIo<double>& io,
                             Drive<double>& drive, SharedState& shared)
    : realtime_{realtime},
      shared_{shared},
      periodic_{{.period_ns = period_ns, .wake_every_periods = realtime.wake_every_periods}, realtime.wait},
      task_{periodic_.schedule().parameters(), drive, shared, realtime.overrun_limit},
      timer_{realtime, io, task_, shared} {}

RightsReport ControlThread::start() {
  thread_.start([this] { run(go_.get_future()); });
  return rights_.get_future().get();
}

void ControlThread::decide(bool may_go) {
  if (decided_) return;
  decided_ = true;
  go_.set_value(may_go);
}

void ControlThread::join() {
  decide(false);
  thread_.join();
}

void ControlThread::run(std::future<bool> may_go) {
  shared_.control_thread_id.store(gettid(), std::memory_order_release);
  rights_.set_value(set_up_control_thread(realtime_, periodic_.schedule().parameters().wake_period_ns()));
  const bool goes = may_go.get();
  timer_.start(periodic_.start());
  while (goes && !task_.has_shut_down()) {
    const WakeSchedule::Wake wake = periodic_.wait();
    timer_.begin(periodic_, wake);
    run_periods(wake.deadline_ns);
    timer_.end(now_ns());
  }
  shared_.stopped.store(true, std::memory_order_release);
}

void ControlThread::run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING {
  task_.wake_up(periodic_.woken_ns(), deadline_ns, periodic_.schedule().counters().overruns_in_a_row,
                timer_.io(), timer_.commands(), timer_.telemetry());
}

}  // namespace sextant::ecu
