#include "ecu/housekeeping_thread.hpp"

#include <chrono>
#include <thread>

namespace sextant::ecu {

void HousekeepingThread::run() {
  using namespace std::chrono_literals;
  constexpr int looks_per_sample = 10;
  const SchedulerSampler sampler{crossings_.control_thread_id.load(std::memory_order_acquire)};
  const SchedulerSample begin = sampler.sample();
  for (int look = 1; !crossings_.stopped.load(std::memory_order_acquire); ++look) {
    std::this_thread::sleep_for(10ms);
    if (look % looks_per_sample != 0) continue;
    const SchedulerSample sample = sampler.sample().since(begin);
    // The last one finds the thread gone; what was known of it stands.
    if (sample.valid) crossings_.scheduler.store(sample);
  }
}

}  // namespace sextant::ecu
