#pragma once

#include <functional>
#include <thread>
#include <utility>

#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// A thread with a name for `ps`, `top` and traces.
class NamedThread {
 public:
  /// At most 15 characters.
  explicit NamedThread(const char* name) : name_{name} {}

  /// Runs `body` on a thread of its own; an exception of it ends the process.
  void start(std::function<void()> body) {
    thread_ = std::thread{[name = name_, run = std::move(body)] {
      (void)name_thread(name);
      run();
    }};
  }

  /// Waits for the body to return. Safe to call twice, and without a start.
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  const char* name_;
  std::thread thread_{};
};

}  // namespace sextant::ecu
