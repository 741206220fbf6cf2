#pragma once

#include <atomic>
#include <cstdint>

#include "ecu/shared/shared_state.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/elapsed.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant::ecu {

/// The requests of the cycle: the newest command, shutdown, and the faults that other threads detect. Only
/// this class clears the gate inhibit, when it passes it on, so that none is lost. Another drive on the bus
/// is a fault while its frames arrive, and for `other_drive_hold_ns` more. A watchdog thread that has stopped
/// is a fault until it runs again: nothing would clear the gate-enable line of a control thread that hangs.
class SharedCommands {
 public:
  static constexpr std::int64_t other_drive_hold_ns = ns_per_s;  ///< [ns]

  /// overrun_limit: overruns in a row that are a fault [-].
  explicit SharedCommands(SharedState& shared,
                          std::uint32_t overrun_limit = RealtimeParameters{}.overrun_limit) noexcept
      : shared_{shared}, overrun_limit_{overrun_limit} {}

  /// To be called once a wake-up, before its periods: overruns in a row, this wake-up's included [-].
  void note_overruns(std::uint32_t in_a_row) noexcept SEXTANT_NONBLOCKING { overruns_in_a_row_ = in_a_row; }

  [[nodiscard]] DriveRequest<double> latest(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    DriveRequest<double> request{.command = shared_.command.latest(),
                                 .shutdown = shared_.shutdown.load(std::memory_order_acquire)};
    const bool inhibit = shared_.gate_inhibit.load(std::memory_order_relaxed) &&
                         shared_.gate_inhibit.exchange(false, std::memory_order_acq_rel);
    const bool is_watched = !shared_.watchdog_stopped.load(std::memory_order_relaxed);
    if (inhibit || !is_watched) request.external.set(Fault::watchdog);
    const std::int64_t other_ns = shared_.other_drive_ns.load(std::memory_order_relaxed);
    if (other_ns != 0 && t_ns - other_ns < other_drive_hold_ns) request.external.set(Fault::second_master);
    if (overruns_in_a_row_ >= overrun_limit_) request.external.set(Fault::overrun);
    const std::int64_t sent_ns = shared_.status_sent_ns.load(std::memory_order_relaxed);
    if (sent_ns >= 0) request.status_age_ns = elapsed(sent_ns, t_ns);
    return request;
  }

 private:
  SharedState& shared_;
  std::uint32_t overrun_limit_;
  std::uint32_t overruns_in_a_row_{0};
};

}  // namespace sextant::ecu
