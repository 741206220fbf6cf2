#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "ecu/shared_state.hpp"

namespace sextant::ecu {

/// What the watchdog does, apart from its thread: while the control thread has timed out it orders the gates
/// off, and takes the gate-enable line away where there is one, so that the gates turn off while that thread
/// still hangs. The order is never withdrawn here: the control thread takes it once it is back, and the drive
/// latches the fault.
class WatchdogTask {
 public:
  static constexpr std::int64_t poll_every_ns = 2'000'000;  ///< [ns]

  /// `inhibit_gates` takes the gate-enable line away.
  explicit WatchdogTask(
      SharedState& shared, std::function<void()> inhibit_gates = [] {})
      : shared_{shared}, inhibit_gates_{std::move(inhibit_gates)} {}

  void poll(std::int64_t now_ns) {
    if (shared_.control_timed_out(now_ns)) inhibit_gates_();
  }

 private:
  SharedState& shared_;
  std::function<void()> inhibit_gates_;
};

}  // namespace sextant::ecu
