#pragma once

#include <atomic>
#include <cstdint>

#include "ecu/shared_state.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant::ecu {

/// The requests of the cycle: the newest command, shutdown, and the faults that other threads detect. Only
/// this class clears the gate inhibit, when it passes it on, so that none is lost. Another drive on the bus
/// is a fault while its frames arrive, and for `other_drive_hold_ns` more.
class SharedCommands {
 public:
  static constexpr std::int64_t other_drive_hold_ns = ns_per_s;  ///< [ns]

  explicit SharedCommands(SharedState& shared) noexcept : shared_{shared} {}

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    DriveRequest<double> request{
        shared_.command.latest(), shared_.shutdown.load(std::memory_order_acquire), {}};
    const bool inhibit = shared_.gate_inhibit.load(std::memory_order_relaxed) &&
                         shared_.gate_inhibit.exchange(false, std::memory_order_acq_rel);
    if (inhibit) request.external.set(Fault::watchdog);
    const std::int64_t other_ns = shared_.other_drive_ns.load(std::memory_order_relaxed);
    if (other_ns != 0 && t_ns - other_ns < other_drive_hold_ns) request.external.set(Fault::second_master);
    return request;
  }

 private:
  SharedState& shared_;
};

}  // namespace sextant::ecu
