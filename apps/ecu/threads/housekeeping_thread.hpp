#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "ecu/shared_state.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The housekeeping thread: ten times a second it asks the kernel for the scheduling of the control thread
/// (time without a processor, switches, page faults, stolen time), which tells a gap in that thread's
/// execution from a long execution without one system call on it.
class HousekeepingThread {
 public:
  explicit HousekeepingThread(SharedState& shared) : shared_{shared} {}

  /// To be called when the control thread has been set up; what the kernel counts from here on is reported.
  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

 private:
  void run() {
    using namespace std::chrono_literals;
    constexpr int polls_per_sample = 10;
    const SchedulerSampler sampler{shared_.control_thread_id.load(std::memory_order_acquire)};
    const SchedulerSample begin = sampler.sample();
    for (int poll = 1; !shared_.stopped.load(std::memory_order_acquire); ++poll) {
      std::this_thread::sleep_for(10ms);
      if (poll % polls_per_sample != 0) continue;
      const SchedulerSample sample = sampler.sample().since(begin);
      // The last one finds the thread gone; the sample before it stands.
      if (sample.valid) shared_.scheduler.store(sample);
    }
  }

  SharedState& shared_;
  NamedThread thread_{"sextant-house"};
};

}  // namespace sextant::ecu
