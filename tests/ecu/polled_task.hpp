#pragma once

#include <chrono>
#include <functional>
#include <utility>

#include "ecu/shared/shared_state.hpp"
#include "ecu/threads/polled_thread.hpp"

namespace sextant::test {

/// Polls a task of a drive on a thread until the drive has stopped.
class PolledTask {
 public:
  PolledTask(ecu::SharedState& shared, std::function<void()> poll, std::function<void()> begin = {},
             std::chrono::milliseconds every = std::chrono::milliseconds{1})
      : shared_{shared}, poll_{std::move(poll)}, begin_{std::move(begin)}, every_{every} {}
  ~PolledTask() { stop(); }
  PolledTask(const PolledTask&) = delete;
  PolledTask& operator=(const PolledTask&) = delete;

  void start() {
    thread_.start({.begin = begin_, .poll = [this] {
                     poll_();
                     return every_;
                   }});
  }
  void stop() {
    shared_.stopped.store(true);
    thread_.join();
  }

 private:
  ecu::SharedState& shared_;
  std::function<void()> poll_;
  std::function<void()> begin_;
  std::chrono::milliseconds every_;
  ecu::PolledThread thread_{"sextant-test", shared_.stopped};
};

}  // namespace sextant::test
