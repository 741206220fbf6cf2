#pragma once

#include "ecu/power_stage.hpp"
#include "ecu/shared_state.hpp"
#include "ecu/threads/named_thread.hpp"

namespace sextant::ecu {

/// The link thread: logs when the plant at the other end of a link appears, times out or does not acknowledge
/// patterns, and ends the program where it is gone for good. The drive's reaction does not depend on it.
class LinkThread {
 public:
  LinkThread(PowerStage& power_stage, SharedState& shared) : power_stage_{power_stage}, shared_{shared} {}

  void start() {
    thread_.start([this] { run(); });
  }
  void join() { thread_.join(); }

 private:
  void run();

  PowerStage& power_stage_;
  SharedState& shared_;
  NamedThread thread_{"sextant-link"};
};

}  // namespace sextant::ecu
