#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "sextant/comms/telemetry_messages.hpp"

namespace sextant::ecu {

/// Tells from the drive's side whether the process that publishes has stopped: from how long no message of it
/// has come, while the drive itself ran. A gap between two steps that is longer than the interval of the
/// reports may be a stop of the whole machine, in which the process could not report either: it counts as one
/// interval. Reads no clock.
class PublisherWatch {
 public:
  /// Twenty reports are missing. [ns]
  static constexpr std::int64_t timeout_ns = 20 * publisher_reports_every_ns;
  /// Before its first message: DDS starts, and the process itself ends a start that hangs. [ns]
  static constexpr std::int64_t start_timeout_ns = std::int64_t{publisher_hang_limit_s} * 1'000'000'000;

  /// A new process.
  constexpr void start() noexcept { *this = {}; }

  /// A message has come.
  constexpr void heard() noexcept {
    silent_ns_ = 0;
    has_reported_ = true;
  }

  /// True once the process counts as stopped. [ns]
  [[nodiscard]] constexpr bool step(std::int64_t now_ns) noexcept {
    if (last_ns_) silent_ns_ += std::clamp<std::int64_t>(now_ns - *last_ns_, 0, publisher_reports_every_ns);
    last_ns_ = now_ns;
    return silent_ns_ > timeout();
  }

  /// Without a message for longer it has stopped. [ns]
  [[nodiscard]] constexpr std::int64_t timeout() const noexcept {
    return has_reported_ ? timeout_ns : start_timeout_ns;
  }

 private:
  std::optional<std::int64_t> last_ns_{};  // of the step before [ns]
  std::int64_t silent_ns_{0};              // time of this program since the last message [ns]
  bool has_reported_{false};
};

}  // namespace sextant::ecu
