#pragma once

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"

namespace sextant::ecu {

/// The housekeeping thread: ten times a second it asks the kernel what became of the control thread (time
/// without a processor, switches, page faults, stolen time), so that a gap in the control thread's work can
/// be told from a long work without one system call on the control thread.
class HousekeepingThread {
 public:
  explicit HousekeepingThread(Crossings& crossings) : crossings_{crossings} {}

  /// To be called when the control thread has been set up; what the kernel counts from here on is reported.
  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }

 private:
  void run();

  Crossings& crossings_;
  Worker worker_{"sextant-house"};
};

}  // namespace sextant::ecu
