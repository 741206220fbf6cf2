#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "ecu/parameters/parameter_service.hpp"
#include "ecu/power_stage.hpp"
#include "ecu/shared_state.hpp"
#include "ecu/threads/named_thread.hpp"

namespace sextant::ecu {

/// The link thread: logs when the plant at the other end of a link appears, times out or does not acknowledge
/// patterns, ends the program where the plant of a lockstep has ended, and takes faults for a simulated
/// plant and parameters for the drive. The drive's reaction does not depend on it.
class LinkThread {
 public:
  LinkThread(PowerStage& power_stage, SharedState& shared) : power_stage_{power_stage}, shared_{shared} {}

  /// Also answers requests for parameters; the service must outlive the thread. Before it starts.
  void serve(ParameterService& parameters) { parameters_ = &parameters; }

  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

 private:
  void run() {
    using namespace std::chrono_literals;
    while (!shared_.stopped.load(std::memory_order_acquire)) {
      // Longer than the first measurement takes, so that each change is logged once.
      std::this_thread::sleep_for(20ms);
      const std::string sentence = power_stage_.state_change();
      if (!sentence.empty()) spdlog::info("{}", sentence);
      power_stage_.poll_faults();
      if (parameters_ != nullptr) parameters_->poll();
      if (!power_stage_.problem().empty()) {
        // main handles the signal like one from outside.
        kill(getpid(), SIGTERM);
        return;
      }
    }
  }

  PowerStage& power_stage_;
  SharedState& shared_;
  ParameterService* parameters_{nullptr};
  NamedThread thread_{"sextant-link"};
};

}  // namespace sextant::ecu
