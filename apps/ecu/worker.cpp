#include "ecu/worker.hpp"

#include <utility>

#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

void Worker::start(std::function<void()> body) {
  thread_ = std::thread{[name = name_, run = std::move(body)] {
    (void)name_thread(name);
    run();
  }};
}

void Worker::join() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace sextant::ecu
