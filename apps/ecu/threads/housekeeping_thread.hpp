#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "ecu/shared_state.hpp"
#include "ecu/threads/named_thread.hpp"
#include "sextant/realtime/scheduler_sample.hpp"

namespace sextant::ecu {

/// The housekeeping thread: ten times a second it reads the kernel's scheduling statistics of the control
/// thread (time without a processor, switches, page faults, stolen time). They distinguish a gap in that
/// thread's execution from a long execution, without a system call on it.
class HousekeepingThread {
 public:
  explicit HousekeepingThread(SharedState& shared) : shared_{shared} {}

  /// To be called when the control thread has been set up; the statistics count from here.
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
      // Not valid once the control thread has ended: the sample before it stays.
      if (sample.valid) shared_.scheduler.store(sample);
    }
  }

  SharedState& shared_;
  NamedThread thread_{"sextant-house"};
};

}  // namespace sextant::ecu
