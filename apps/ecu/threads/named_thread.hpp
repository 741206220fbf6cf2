#pragma once

#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// A thread with a name for `ps`, `top` and traces.
class NamedThread {
 public:
  /// At most 15 characters.
  explicit NamedThread(std::string name) : name_{std::move(name)} {}

  /// Runs `function` on a thread of its own; an exception of it ends the process.
  void start(std::function<void()> function) {
    thread_ = std::thread{[name = name_, run = std::move(function)] {
      (void)name_thread(name);
      run();
    }};
  }

  /// Waits until the function has returned. Safe to call twice, and without a start.
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::string name_;
  std::thread thread_{};
};

}  // namespace sextant::ecu
