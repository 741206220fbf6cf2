#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/torque_command.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

/// Measures the time from the arrival of a command's frame to the first gate pattern decided with it. Used by
/// the control thread; a period without a new command reads no clock.
class CommandProbe {
 public:
  /// The command of this period.
  void add(const TorqueCommand<double>& command) noexcept SEXTANT_NONBLOCKING {
    if (command.sequence == sequence_) return;
    sequence_ = command.sequence;
    arrival_ns_ = command.received_ns;
    waiting_ = true;
  }

  /// The pattern of this period has been written.
  void written() noexcept SEXTANT_NONBLOCKING {
    if (waiting_) longest_ns_ = std::max(longest_ns_, clock_ns() - arrival_ns_);
    waiting_ = false;
  }

  /// The longest since the last call; 0 where no command was new. [ns]
  [[nodiscard]] std::int64_t take_longest_ns() noexcept SEXTANT_NONBLOCKING {
    return std::exchange(longest_ns_, 0);
  }

 private:
  SEXTANT_TRUSTED_BEGIN
  // The vDSO reads the clock without a system call.
  [[nodiscard]] static std::int64_t clock_ns() noexcept SEXTANT_NONBLOCKING { return now_ns(); }
  SEXTANT_TRUSTED_END

  std::uint64_t sequence_{0};
  bool waiting_{false};
  std::int64_t arrival_ns_{0};
  std::int64_t longest_ns_{0};
};

}  // namespace sextant::ecu
