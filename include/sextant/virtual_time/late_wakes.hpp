#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sextant {

/// One wake-up that comes late.
struct LateWake {
  std::int64_t at_ns{};       ///< the first deadline from here on is the one that is missed [ns]
  std::int64_t latency_ns{};  ///< from that deadline to the wake-up [ns]
};

/// The wake-ups of a thread that sleeps until deadlines: in time, but for a list of late ones. Each entry
/// applies to one deadline; deadlines missed by a late wake-up have none.
class LateWakes {
 public:
  LateWakes() = default;

  /// Throws std::invalid_argument when the list is not in order of time or a latency is negative.
  explicit LateWakes(std::vector<LateWake> wakes) : wakes_{std::move(wakes)} {
    for (std::size_t k = 0; k < wakes_.size(); ++k) {
      if (wakes_[k].latency_ns < 0) throw std::invalid_argument{"a wake-up cannot come before its deadline"};
      if (k > 0 && wakes_[k].at_ns < wakes_[k - 1].at_ns) {
        throw std::invalid_argument{"late wake-ups must be in order of time"};
      }
    }
  }

  /// When the sleep until deadline_ns ends. [ns]
  [[nodiscard]] std::int64_t wake_ns(std::int64_t deadline_ns) const noexcept {
    const bool late = next_ < wakes_.size() && wakes_[next_].at_ns <= deadline_ns;
    return late ? deadline_ns + wakes_[next_].latency_ns : deadline_ns;
  }

  /// That sleep is over.
  void woken(std::int64_t deadline_ns) noexcept {
    if (next_ < wakes_.size() && wakes_[next_].at_ns <= deadline_ns) ++next_;
  }

 private:
  std::vector<LateWake> wakes_{};
  std::size_t next_{0};
};

}  // namespace sextant
