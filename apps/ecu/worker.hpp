#pragma once

#include <functional>
#include <thread>

namespace sextant::ecu {

/// A thread with a name for `ps`, `top` and traces.
class Worker {
 public:
  /// At most 15 characters.
  explicit Worker(const char* name) : name_{name} {}

  /// Runs `body` on a thread of its own; an exception of it ends the process.
  void start(std::function<void()> body);

  /// Waits for the body to return. Safe to call twice, and without a start.
  void join();

 private:
  const char* name_;
  std::thread thread_{};
};

}  // namespace sextant::ecu
