#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "ecu/unit/drive_unit.hpp"
#include "sextant/config/drives_config.hpp"
#include "sextant/core/fault.hpp"

namespace sextant::ecu {

/// What the fault of a drive means for the other drives of its process. With `all_shut_down` the first fault
/// ends the run: every drive ramps its torque to zero and shuts down. A control thread that has timed out is
/// such a fault (WATCHDOG).
class FaultReaction {
 public:
  /// The drives are not owned and must outlive this object.
  FaultReaction(OnFault on_fault, std::vector<DriveUnit*> drives)
      : on_fault_{on_fault}, drives_{std::move(drives)} {}

  /// Whether a fault ends the run.
  [[nodiscard]] bool ends_run() const noexcept { return on_fault_ == OnFault::all_shut_down; }

  /// To be called every few milliseconds, by one thread; now_ns on the clock of the control periods [ns].
  void poll(std::int64_t now_ns) noexcept {
    if (!ends_run() || has_ended()) return;
    for (DriveUnit* candidate : drives_) {
      const std::optional<Fault> fault = fault_of(candidate->shared(), now_ns);
      if (!fault) continue;
      fault_ = *fault;
      faulted_.store(candidate, std::memory_order_release);
      for (DriveUnit* drive : drives_) drive->shut_down();
      return;
    }
  }

  /// A fault has ended the run; from any thread.
  [[nodiscard]] bool has_ended() const noexcept {
    return faulted_.load(std::memory_order_acquire) != nullptr;
  }

  /// Why the run ended, in one sentence; empty where no fault has ended it. From any thread.
  [[nodiscard]] std::string problem() const {
    const DriveUnit* const faulted = faulted_.load(std::memory_order_acquire);
    if (faulted == nullptr) return {};
    return fmt::format("drive {} went to FAULT ({}): every drive has shut down (on_fault)",
                       faulted->config().drive_id, to_string(fault_));
  }

 private:
  static std::optional<Fault> fault_of(SharedState& shared, std::int64_t now_ns) noexcept {
    if (shared.control_timed_out(now_ns)) return Fault::watchdog;
    return shared.fault.load(std::memory_order_relaxed);
  }

  OnFault on_fault_;
  std::vector<DriveUnit*> drives_;
  Fault fault_{};  // of the drive that has ended the run: stored before it
  std::atomic<const DriveUnit*> faulted_{nullptr};
};

}  // namespace sextant::ecu
