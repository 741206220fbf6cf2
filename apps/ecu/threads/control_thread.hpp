#pragma once

#include <cstdint>
#include <future>
#include <string>

#include "ecu/shared/cycle_recorder.hpp"
#include "ecu/shared/shared_state.hpp"
#include "ecu/tasks/control_task.hpp"
#include "ecu/threads/named_thread.hpp"
#include "ecu/threads/wake_timer.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// The control thread: wakes on absolute deadlines, runs the control periods that are due, and stops once the
/// drive has shut down. Its loop never allocates, locks, throws, logs or blocks.
class ControlThread {
 public:
  /// Power stage, task, shared state and recorder are not owned and must outlive this object. `cycles`:
  /// records the control periods; nullptr for none. `name`: of the thread, at most 15 characters.
  ControlThread(const RealtimeParameters& realtime, DriveIo<double>& io, ControlTask& task,
                SharedState& shared, CycleRecorder* cycles = nullptr, std::string name = "sextant-control");

  /// Starts the thread and waits until it has requested its rights; returns those granted. The thread then
  /// sleeps until go(), so that it does not starve the thread that checks the rights.
  [[nodiscard]] RightsReport start();
  /// Starts the control periods; once.
  void go() { decide(true); }
  /// Without go() the thread ends without a period.
  void join();

 private:
  void decide(bool may_go);
  void run(std::future<bool> may_go);
  /// The control periods of one wake-up.
  void run_periods(std::int64_t deadline_ns) noexcept SEXTANT_NONBLOCKING;

  RealtimeParameters realtime_;
  DriveIo<double>& io_;
  ControlTask& task_;
  SharedState& shared_;
  PeriodicTask periodic_;
  WakeTimer timer_;
  // Members, because they must outlive the thread: set_value may still run when the value has been read.
  std::promise<RightsReport> rights_{};
  std::promise<bool> go_{};
  bool decided_{false};
  NamedThread thread_;
};

}  // namespace sextant::ecu
