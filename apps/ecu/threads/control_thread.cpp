#include "ecu/threads/control_thread.hpp"

#include <utility>

#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

ControlThread::ControlThread(const RealtimeParameters& realtime, DriveIo<double>& io, ControlTask& task,
                             SharedState& shared, CycleRecorder* cycles, std::string name)
    : realtime_{realtime},
      io_{io},
      task_{task},
      shared_{shared},
      periodic_{task.wakes(), realtime.wait},
      timer_{realtime, shared, cycles},
      thread_{std::move(name)} {}

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
  task_.wake_up(periodic_.woken_ns(), deadline_ns, periodic_.schedule().counters().overruns_in_a_row, io_,
                timer_);
}

}  // namespace sextant::ecu
