#pragma once

#include "ecu/crossings.hpp"
#include "ecu/power_stage.hpp"
#include "ecu/worker.hpp"

namespace sextant::ecu {

/// Tells people when the plant at the other end of a link appears and falls silent. The drive's reaction does
/// not depend on it.
class PowerStageMonitor {
 public:
  PowerStageMonitor(PowerStage& power_stage, Crossings& crossings)
      : power_stage_{power_stage}, crossings_{crossings} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }

 private:
  void run();

  PowerStage& power_stage_;
  Crossings& crossings_;
  Worker worker_{"sextant-link"};
};

}  // namespace sextant::ecu
