#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "ecu/threads/named_thread.hpp"

namespace sextant::ecu {

/// A thread that polls its work until it is over and sleeps between two polls.
class PolledThread {
 public:
  struct Work {
    std::function<void()> begin{};                   ///< once, before the first poll; may be empty
    std::function<std::chrono::nanoseconds()> poll;  ///< returns the time to the next poll
    std::function<void()> end{};                     ///< once, after the last poll; may be empty
  };

  /// name: at most 15 characters. is_over: read before each poll; must outlive this object.
  PolledThread(std::string name, const std::atomic<bool>& is_over)
      : is_over_{is_over}, thread_{std::move(name)} {}

  /// The functions are called from the thread; an exception of theirs ends the process.
  void start(Work work) {
    thread_.start([this, work = std::move(work)] {
      if (work.begin) work.begin();
      while (!is_over_.load(std::memory_order_acquire)) std::this_thread::sleep_for(work.poll());
      if (work.end) work.end();
    });
  }
  /// Waits until the work has ended. Safe to call twice, and without a start.
  void join() { thread_.join(); }

 private:
  const std::atomic<bool>& is_over_;
  NamedThread thread_;
};

}  // namespace sextant::ecu
