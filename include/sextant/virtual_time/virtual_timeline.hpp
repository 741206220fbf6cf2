#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "sextant/virtual_time/virtual_clock.hpp"

namespace sextant {

/// A party with actions at certain instants: a node of the bus, a task of the drive.
struct VirtualParty {
  std::function<std::int64_t()> next_due_ns;  ///< instant of the next action; `never_ns`: none [ns]
  std::function<void()> act;                  ///< does what is due by now; moves its next instant on
};

/// Runs parties one after the other in order of virtual time; those due at one instant act in the order in
/// which they were added, so that a run has one order only. A party whose next instant lies in the past acts
/// now.
class VirtualTimeline {
 public:
  /// The clock is not owned and must outlive this object.
  explicit VirtualTimeline(VirtualClock& clock) noexcept : clock_{clock} {}

  void add(VirtualParty party) { parties_.push_back(std::move(party)); }

  /// Runs everything that is due up to t_ns, that instant included, and leaves the clock there. [ns]
  void run_until(std::int64_t t_ns) {
    while (step(t_ns)) {
    }
    clock_.advance_to(std::max(clock_.now_ns(), t_ns));
  }

  /// Lets the next party act, unless that is later than t_ns [ns]; true when one did.
  bool step(std::int64_t t_ns) {
    const VirtualParty* next = nullptr;
    std::int64_t due_ns = never_ns;
    for (const VirtualParty& party : parties_) {
      const std::int64_t wanted_ns = party.next_due_ns();
      if (wanted_ns >= due_ns) continue;
      // The past counts as now, for all parties alike.
      due_ns = std::max(wanted_ns, clock_.now_ns());
      next = &party;
      if (due_ns == clock_.now_ns()) break;
    }
    if (next == nullptr || due_ns > t_ns) return false;
    clock_.advance_to(due_ns);
    next->act();
    return true;
  }

 private:
  VirtualClock& clock_;
  std::vector<VirtualParty> parties_{};
};

}  // namespace sextant
