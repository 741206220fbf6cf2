#include "ecu/power_stage_monitor.hpp"

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <spdlog/spdlog.h>
#include <unistd.h>

namespace sextant::ecu {

void PowerStageMonitor::run() {
  using namespace std::chrono_literals;
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    // Longer than a first measurement takes, so that an absence is told once and a presence not twice.
    std::this_thread::sleep_for(20ms);
    const std::string sentence = power_stage_.news();
    if (!sentence.empty()) spdlog::info("{}", sentence);
    if (!power_stage_.problem().empty()) {
      // Main takes it as it takes that of anybody else.
      kill(getpid(), SIGTERM);
      return;
    }
  }
}

}  // namespace sextant::ecu
