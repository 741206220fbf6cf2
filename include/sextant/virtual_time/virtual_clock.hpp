#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace sextant {

/// An instant that never comes. [ns]
inline constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();

/// The clock of a run in virtual time. It advances by calls only, so that a run depends neither on the
/// machine nor on execution times.
class VirtualClock {
 public:
  explicit VirtualClock(std::int64_t start_ns = 0) noexcept : now_ns_{start_ns} {}
  VirtualClock(const VirtualClock&) = delete;
  VirtualClock& operator=(const VirtualClock&) = delete;

  /// Virtual time. [ns]
  [[nodiscard]] std::int64_t now_ns() const noexcept { return now_ns_; }

  /// Moves the clock on. Throws std::logic_error for a time that has passed [ns].
  void advance_to(std::int64_t t_ns) {
    if (t_ns < now_ns_) throw std::logic_error{"a virtual clock cannot go back"};
    now_ns_ = t_ns;
  }

 private:
  std::int64_t now_ns_;
};

}  // namespace sextant
