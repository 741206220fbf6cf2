#include "ecu/threads/link_thread.hpp"

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <spdlog/spdlog.h>
#include <unistd.h>

namespace sextant::ecu {

void LinkThread::run() {
  using namespace std::chrono_literals;
  while (!shared_.stopped.load(std::memory_order_acquire)) {
    // Longer than a first measurement takes, so that an absence is logged once and a presence not twice.
    std::this_thread::sleep_for(20ms);
    const std::string sentence = power_stage_.state_change();
    if (!sentence.empty()) spdlog::info("{}", sentence);
    if (!power_stage_.problem().empty()) {
      // Main handles it as one from outside.
      kill(getpid(), SIGTERM);
      return;
    }
  }
}

}  // namespace sextant::ecu
