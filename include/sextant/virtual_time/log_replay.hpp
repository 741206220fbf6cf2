#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "sextant/comms/status_encoder.hpp"
#include "sextant/virtual_time/candump_log.hpp"
#include "sextant/virtual_time/virtual_can_bus.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant {

/// Plays a log to the bus: its first frame at virtual time zero, the others as far behind it as they were
/// recorded. Status frames of the drives are left out, because those that listen send their own.
class LogReplay {
 public:
  /// The bus is not owned and must outlive this object, which must stay where it is.
  /// offsets: of the identifiers of each listening drive.
  LogReplay(std::vector<LoggedFrame> log, VirtualCanBus& bus, const std::vector<IdentifierOffset>& offsets)
      : log_{std::move(log)}, bus_{bus}, origin_ns_{log_.empty() ? 0 : log_.front().t_ns} {
    left_out_ = std::erase_if(log_, [&offsets](const LoggedFrame& logged) {
      return std::ranges::any_of(
          offsets, [&logged](IdentifierOffset offset) { return is_status_frame(logged.frame, offset); });
    });
  }

  /// When the next frame is due; `never_ns` after the last. [ns]
  [[nodiscard]] std::int64_t next_due_ns() const noexcept {
    return next_ < log_.size() ? log_[next_].t_ns - origin_ns_ : never_ns;
  }
  /// Virtual time of the last frame. [ns]
  [[nodiscard]] std::int64_t end_ns() const noexcept {
    return log_.empty() ? 0 : log_.back().t_ns - origin_ns_;
  }
  /// What the log calls virtual time zero. [ns]
  [[nodiscard]] std::int64_t origin_ns() const noexcept { return origin_ns_; }

  [[nodiscard]] std::size_t left_out() const noexcept { return left_out_; }  ///< status frames [-]

  [[nodiscard]] VirtualParty party() {
    return {.next_due_ns = [this] { return next_due_ns(); },
            .act = [this] { bus_.put(log_[next_++].frame); }};
  }

 private:
  std::vector<LoggedFrame> log_;
  VirtualCanBus& bus_;
  std::int64_t origin_ns_;
  std::size_t next_{0};
  std::size_t left_out_{0};
};

}  // namespace sextant
