#pragma once

#include <atomic>
#include <utility>
#include <vector>

#include "ecu/unit/drive_unit.hpp"
#include "sextant/config/drives_config.hpp"

namespace sextant::ecu {

/// What the fault of a drive means for the other drives of its process.
class FaultReaction {
 public:
  /// The drives are not owned and must outlive this object.
  FaultReaction(OnFault on_fault, std::vector<DriveUnit*> drives)
      : on_fault_{on_fault}, drives_{std::move(drives)} {}

  /// To be called every few milliseconds. A drive that shuts down ramps its torque to zero first.
  void poll() noexcept {
    if (on_fault_ == OnFault::others_go_on) return;
    for (const DriveUnit* faulted : drives_) {
      if (!faulted->shared().is_in_fault.load(std::memory_order_relaxed)) continue;
      for (DriveUnit* drive : drives_) {
        if (drive != faulted) drive->shut_down();
      }
    }
  }

 private:
  OnFault on_fault_;
  std::vector<DriveUnit*> drives_;
};

}  // namespace sextant::ecu
