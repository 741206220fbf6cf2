#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

#include "ecu/shared/shared_state.hpp"

namespace sextant::ecu {

/// The work of the watchdog thread for a drive, without the thread: while the control thread has timed out it
/// sets the gate inhibit and clears the gate-enable line of a link, so that the gates turn off while that
/// thread hangs. The control thread clears the gate inhibit when it runs again, and the drive latches the
/// fault. It shares only two atomics and the gate-enable line with the control thread; its count of polls
/// shows the housekeeping thread that it runs.
class WatchdogTask {
 public:
  static constexpr std::int64_t poll_every_ns = 2'000'000;  ///< [ns]

  /// `inhibit_gates` clears the gate-enable line; it is called at each poll while the control thread has
  /// timed out.
  explicit WatchdogTask(
      SharedState& shared, std::function<void()> inhibit_gates = [] {})
      : shared_{shared}, inhibit_gates_{std::move(inhibit_gates)} {}

  void poll(std::int64_t now_ns) {
    if (shared_.control_timed_out(now_ns)) inhibit_gates_();
    shared_.watchdog_polls.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  SharedState& shared_;
  std::function<void()> inhibit_gates_;
};

}  // namespace sextant::ecu
